// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/detail/cpu_target.h>

#include "kernels/walk_kernel.h"

namespace superray {

template <int Dim>
WalkKernels<Dim> bestKernels() {
#if defined(__x86_64__)
    switch (instructionSet()) {
        case InstructionSet::avx512:
            return avx512Kernels<Dim>();
        case InstructionSet::avx2:
            return avx2Kernels<Dim>();
        case InstructionSet::portable:
            break;
    }
#endif
    return portableKernels<Dim>();
}

template WalkKernels<2> bestKernels();
template WalkKernels<3> bestKernels();

}  // namespace superray
