#include "threads/in_turns.h"

#include <gtest/gtest.h>

#include <vector>

namespace superray {
namespace {

TEST(InTurns, TakesEachStepOnceAndThoseOfAPlaceInOrder) {
    for (std::size_t count = 0; count < 40; ++count) {
        std::vector<int> times(count);
        std::vector<std::size_t> ofPlace[4];
        inTurns(count, [&](std::size_t place, std::size_t i) {
            ASSERT_LT(place, 4u);
            ASSERT_LT(i, count);
            ++times[i];
            if (!ofPlace[place].empty()) {
                ASSERT_EQ(i, ofPlace[place].back() + 1);
            }
            ofPlace[place].push_back(i);
        });
        EXPECT_EQ(times, std::vector<int>(count, 1));
    }
}

TEST(InTurns, NeighboursAreNotTakenOneAfterTheOther) {
    std::size_t before = 0, neighbours = 0;
    inTurns(400, [&](std::size_t, std::size_t i) {
        neighbours += i == before + 1;
        before = i;
    });
    EXPECT_EQ(neighbours, 0u);
}

}  // namespace
}  // namespace superray
