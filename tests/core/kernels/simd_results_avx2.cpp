// SPDX-License-Identifier: BSD-3-Clause
#define SUPERRAY_TARGET_AVX2
#if defined(__x86_64__)
#include "kernels/simd/avx2.h"

#include "core/kernels/simd_operations.h"

namespace superray::test {

SimdResults avx2Results(std::uint64_t seed) {
    OperationRun<Avx2> run(seed);
    run.all();
    return run.results;
}

}  // namespace superray::test
#endif
