// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/simd/portable.h"

#include "core/kernels/simd_operations.h"

namespace superray::test {

SimdResults portableResults(std::uint64_t seed) {
    OperationRun<Portable> run(seed);
    run.all();
    return run.results;
}

}  // namespace superray::test
