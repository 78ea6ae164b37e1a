// SPDX-License-Identifier: BSD-3-Clause
#include "threads/interleave.h"

#include <gtest/gtest.h>

#include <vector>

namespace superray {
namespace {

TEST(Interleave, TakesEachStepOnceAndThoseOfALaneInOrder) {
    for (std::size_t count = 0; count < 40; ++count) {
        std::vector<int> times(count);
        std::vector<std::size_t> ofLane[4];
        interleave(count, [&](std::size_t lane, std::size_t i) {
            ASSERT_LT(lane, 4u);
            ASSERT_LT(i, count);
            ++times[i];
            if (!ofLane[lane].empty()) {
                ASSERT_EQ(i, ofLane[lane].back() + 1);
            }
            ofLane[lane].push_back(i);
        });
        EXPECT_EQ(times, std::vector<int>(count, 1));
    }
}

TEST(Interleave, NeighboursAreNotTakenOneAfterTheOther) {
    std::size_t before = 0, neighbours = 0;
    interleave(400, [&](std::size_t, std::size_t i) {
        neighbours += i == before + 1;
        before = i;
    });
    EXPECT_EQ(neighbours, 0u);
}

}  // namespace
}  // namespace superray
