// SPDX-License-Identifier: BSD-3-Clause
#include "threads/backoff.h"

#include <gtest/gtest.h>

namespace superray {
namespace {

TEST(Backoff, GoOnWhileTheyRepay) {
    Backoff backoff;
    for (int i = 0; i < 30; ++i) {
        ASSERT_TRUE(backoff.tryNow()) << i;
        backoff.learn(true);
    }
}

TEST(Backoff, WaitAfterOneInVain) {
    Backoff backoff;
    for (int round = 0; round < 3; ++round) {
        backoff.learn(false);
        for (int i = 1; i < Backoff::kChances; ++i) ASSERT_FALSE(backoff.tryNow()) << i;
        ASSERT_TRUE(backoff.tryNow()) << round;
    }
    // Nothing was learnt of the last one, so there is no reason to wait.
    EXPECT_TRUE(backoff.tryNow());
}

}  // namespace
}  // namespace superray
