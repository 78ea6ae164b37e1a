// SPDX-License-Identifier: BSD-3-Clause
#include "threads/backoff.h"

#include <gtest/gtest.h>

namespace superray {
namespace {

TEST(Backoff, GoOnWhileTheyRepay) {
    Backoff attempts;
    for (int i = 0; i < 30; ++i) {
        ASSERT_TRUE(attempts.tryNow()) << i;
        attempts.learn(true);
    }
}

TEST(Backoff, WaitAfterOneInVain) {
    Backoff attempts;
    for (int round = 0; round < 3; ++round) {
        attempts.learn(false);
        for (int i = 1; i < Backoff::kChances; ++i) ASSERT_FALSE(attempts.tryNow()) << i;
        ASSERT_TRUE(attempts.tryNow()) << round;
    }
    // Nothing was learnt of the last one, so there is no reason to wait.
    EXPECT_TRUE(attempts.tryNow());
}

}  // namespace
}  // namespace superray
