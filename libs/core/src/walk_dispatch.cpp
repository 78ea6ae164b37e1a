#include "walk_kernel.h"

#include <cstdlib>
#include <string>

namespace superray {

template <int Dim>
WalkKernel<Dim> bestWalkKernel() {
#if defined(__x86_64__)
    const char* asked = std::getenv("SUPERRAY_INSTRUCTION_SET");
    const std::string limit = asked != nullptr ? asked : "";
    if (limit == "portable") return walkPortable<Dim>;
    if (limit != "avx2" && __builtin_cpu_supports("avx512f") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"))
        return walkAvx512<Dim>;
    if (__builtin_cpu_supports("avx2")) return walkAvx2<Dim>;
#endif
    return walkPortable<Dim>;
}

template WalkKernel<2> bestWalkKernel();
template WalkKernel<3> bestWalkKernel();

}  // namespace superray
