// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/version.h>

#include <gtest/gtest.h>

#include <string>

// CMake reads the text, programs that choose by version read the numbers.
TEST(Version, TextIsMadeOfTheNumbers) {
    EXPECT_EQ(SUPERRAY_VERSION, std::to_string(SUPERRAY_VERSION_MAJOR) + "." +
                                    std::to_string(SUPERRAY_VERSION_MINOR) + "." +
                                    std::to_string(SUPERRAY_VERSION_PATCH));
}
