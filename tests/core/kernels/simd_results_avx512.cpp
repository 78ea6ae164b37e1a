// SPDX-License-Identifier: BSD-3-Clause
#define SUPERRAY_TARGET_AVX512
#if defined(__x86_64__)
#include "kernels/simd/avx512.h"

#include "core/kernels/simd_operations.h"

namespace superray::test {

SimdResults avx512Results(std::uint64_t seed) {
    OperationRun<Avx512> run(seed);
    run.all();
    return run.results;
}

}  // namespace superray::test
#endif
