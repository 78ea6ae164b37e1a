// SPDX-License-Identifier: BSD-3-Clause
// The kernels for Avx512.
#define SUPERRAY_TARGET_AVX512

#if defined(__x86_64__)
#include "kernels/generic/kernel_table.h"
#include "kernels/simd/avx512.h"

namespace superray {

template <int Dim>
WalkKernels<Dim> avx512Kernels() {
    return kernelTable<Avx512, Dim>();
}

template WalkKernels<2> avx512Kernels();
template WalkKernels<3> avx512Kernels();

}  // namespace superray
#endif
