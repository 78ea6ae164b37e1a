// SPDX-License-Identifier: BSD-3-Clause
#include "skipping/ray_sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <vector>

namespace superray {
namespace {

TEST(RaySample, IsSpreadAndDependsOnTheNumberOfRaysOnly) {
    constexpr double kFrom = 0.03, kTo = 0.13, kShare = kTo - kFrom;
    RaySample used(kFrom, kTo);
    for (const std::size_t count : {0u, 5000u, 37u, 1u, 100000u, 640u}) {
        RaySample fresh(kFrom, kTo);
        const std::vector<std::uint32_t> sample = used.of(count);
        ASSERT_EQ(sample, fresh.of(count)) << count;
        ASSERT_EQ(std::adjacent_find(sample.begin(), sample.end(), std::greater_equal<>{}),
                  sample.end());
        for (const std::uint32_t ray : sample) ASSERT_LT(ray, count);
        const double expected = kShare * static_cast<double>(count);
        EXPECT_NEAR(static_cast<double>(sample.size()), expected, 2) << count;
    }
    // No column of a depth image is sampled much more than others.
    constexpr std::uint32_t kColumns = 640, kRows = 480;
    std::vector<int> perColumn(kColumns);
    for (const std::uint32_t ray : used.of(kColumns * kRows)) ++perColumn[ray % kColumns];
    const double mean = kShare * kRows;
    for (const int n : perColumn) {
        EXPECT_GT(n, 0.5 * mean);
        EXPECT_LT(n, 1.5 * mean);
    }
}

TEST(RaySample, ThoseOfOtherPlacesHaveOtherRays) {
    constexpr std::size_t kCount = 10000;
    RaySample first(0, 0.25), second(0.25, 0.5), both(0, 0.5);
    std::vector<std::uint32_t> merged;
    std::merge(first.of(kCount).begin(), first.of(kCount).end(), second.of(kCount).begin(),
               second.of(kCount).end(), std::back_inserter(merged));
    EXPECT_EQ(merged, both.of(kCount));
    EXPECT_NEAR(static_cast<double>(second.of(kCount).size()), 0.25 * kCount, 10);
}

}  // namespace
}  // namespace superray
