// SPDX-License-Identifier: BSD-3-Clause
// Every operation of every instruction set, against Portable, which is their definition.

#include <superray/core/detail/cpu_target.h>

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "core/kernels/simd_results.h"

namespace superray::test {
namespace {

constexpr std::uint64_t kSeeds = 2000;

void compareWithPortable(SimdResults (*resultsOf)(std::uint64_t)) {
    std::size_t compared = 0;
    std::set<std::string> operations;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        const SimdResults expected = portableResults(seed), results = resultsOf(seed);
        ASSERT_EQ(results.size(), expected.size()) << "seed " << seed;
        for (std::size_t i = 0; i < results.size(); ++i) {
            ASSERT_STREQ(results[i].operation, expected[i].operation);
            ASSERT_EQ(results[i].value, expected[i].value)
                << results[i].operation << ", seed " << seed << ", value " << i;
            operations.insert(results[i].operation);
            ++compared;
        }
    }
    EXPECT_GT(compared, 200 * kSeeds);
    EXPECT_EQ(operations.size(), 31u);
}

#if defined(__x86_64__)
TEST(Simd, Avx2DoesWhatPortableDoes) {
    if (bestInstructionSet() < InstructionSet::avx2) GTEST_SKIP() << "no AVX2 here";
    compareWithPortable(avx2Results);
}

TEST(Simd, Avx512DoesWhatPortableDoes) {
    if (bestInstructionSet() < InstructionSet::avx512) GTEST_SKIP() << "no AVX-512 here";
    compareWithPortable(avx512Results);
}
#endif

}  // namespace
}  // namespace superray::test
