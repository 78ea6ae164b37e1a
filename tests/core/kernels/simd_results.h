// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace superray::test {

/// What one lane of one operation gave.
struct SimdResult {
    const char* operation;
    std::uint64_t value;
};
using SimdResults = std::vector<SimdResult>;

/// What all operations make of the inputs of a seed. \pre the processor has the set
SimdResults portableResults(std::uint64_t seed);
SimdResults avx2Results(std::uint64_t seed);
SimdResults avx512Results(std::uint64_t seed);

}  // namespace superray::test
