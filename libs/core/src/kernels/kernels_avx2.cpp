// SPDX-License-Identifier: BSD-3-Clause
// The kernels for Avx2.
#define SUPERRAY_TARGET_AVX2

#if defined(__x86_64__)
#include "kernels/generic/kernel_table.h"
#include "kernels/simd/avx2.h"

namespace superray {

template <int Dim>
WalkKernels<Dim> avx2Kernels() {
    return kernelTable<Avx2, Dim>();
}

template WalkKernels<2> avx2Kernels();
template WalkKernels<3> avx2Kernels();

}  // namespace superray
#endif
