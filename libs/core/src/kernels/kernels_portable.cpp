// SPDX-License-Identifier: BSD-3-Clause
// The kernels for any processor.
#include "kernels/generic/kernel_table.h"
#include "kernels/simd/portable.h"

namespace superray {

template <int Dim>
WalkKernels<Dim> portableKernels() {
    return kernelTable<Portable, Dim>();
}

template WalkKernels<2> portableKernels();
template WalkKernels<3> portableKernels();

}  // namespace superray
