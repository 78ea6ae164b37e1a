#include "walk_kernel.h"

#include <cstdlib>
#include <string>

namespace superray {

template <int Dim>
WalkKernels<Dim> bestKernels() {
#if defined(__x86_64__)
    const char* asked = std::getenv("SUPERRAY_INSTRUCTION_SET");
    const std::string limit = asked != nullptr ? asked : "";
    if (limit == "portable") return portableKernels<Dim>();
    if (limit != "avx2" && __builtin_cpu_supports("avx512f") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"))
        return avx512Kernels<Dim>();
    if (__builtin_cpu_supports("avx2")) return avx2Kernels<Dim>();
#endif
    return portableKernels<Dim>();
}

template WalkKernels<2> bestKernels();
template WalkKernels<3> bestKernels();

}  // namespace superray
