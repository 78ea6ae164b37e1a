// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>
#include <string>

#include "kernels/walk_kernel.h"

namespace superray {
namespace {

enum class InstructionSet { portable, avx2, avx512 };

InstructionSet bestInstructionSet() {
#if defined(__x86_64__)
    const char* asked = std::getenv("SUPERRAY_INSTRUCTION_SET");
    const std::string limit = asked != nullptr ? asked : "";
    if (limit == "portable") return InstructionSet::portable;
    if (limit != "avx2" && __builtin_cpu_supports("avx512f") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"))
        return InstructionSet::avx512;
    if (__builtin_cpu_supports("avx2")) return InstructionSet::avx2;
#endif
    return InstructionSet::portable;
}

}  // namespace

template <int Dim>
WalkKernels<Dim> bestKernels() {
    switch (bestInstructionSet()) {
#if defined(__x86_64__)
        case InstructionSet::avx512:
            return avx512Kernels<Dim>();
        case InstructionSet::avx2:
            return avx2Kernels<Dim>();
#endif
        default:
            return portableKernels<Dim>();
    }
}

template WalkKernels<2> bestKernels();
template WalkKernels<3> bestKernels();

}  // namespace superray
