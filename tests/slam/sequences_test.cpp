// SPDX-License-Identifier: BSD-3-Clause
// superray-slam on real recordings, without their poses: the accuracy that we
// promise. The recordings may not be redistributed.

#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "eval/run_program.h"

namespace superray {
namespace {

struct Sequence {
    const char *name, *config;
    std::size_t scans;
    double path;              ///< [m]
    double mostDrift;         ///< of the path
    double mostAbsoluteRmse;  ///< [m]
};

// What is measured is in doc/slam.md; these are the promises.
const Sequence kSequences[] = {
    {"kitti_hdl64", "superray-slam-lidar-outdoor.ini", 30, 28.4, 0.01, 0.05},
    {"ouster_hall", "superray-slam-lidar-indoor.ini", 30, 10.5, 0.02, 0.02},
    {"rgbd_room", "superray-slam-rgbd.ini", 100, 3.99, 0.02, 0.03},
};

class RealSequence : public ::testing::TestWithParam<Sequence> {};

TEST_P(RealSequence, DriftAndAbsoluteErrorAreSmall) {
    const Sequence& s = GetParam();
    const std::string input = SUPERRAY_SHARED_DATA_DIR "/" + std::string(s.name);
    if (!std::filesystem::exists(input + ".rawlog"))
        GTEST_SKIP() << input << ".rawlog is not there: SLAM ACCURACY IS NOT TESTED";
    const test::TempFolder folder;
    const auto built = test::runProgram(
        folder, SUPERRAY_SLAM_APP,
        "build '" + input + ".rawlog' -o '" + (folder / "estimate.tum") +
            "' --map-section map --config '" SUPERRAY_CONFIG_FILES_DIR "/" + s.config + "'");
    ASSERT_EQ(built.code, 0) << built.error;
    const auto evaluated = test::runProgram(
        folder, SUPERRAY_SLAM_APP,
        "evaluate --json '" + (folder / "estimate.tum") + "' '" + input + ".tum'");
    ASSERT_EQ(evaluated.code, 0) << evaluated.error;
    const auto error = nlohmann::json::parse(evaluated.out);
    EXPECT_EQ(error["poses"], s.scans);
    EXPECT_NEAR(error["path"].get<double>(), s.path, 0.1);
    EXPECT_LE(error["drift"].get<double>(), s.mostDrift) << evaluated.out;
    EXPECT_LE(error["ate"]["rmse"].get<double>(), s.mostAbsoluteRmse) << evaluated.out;
    std::cout << s.name << ": drift " << 100 * error["drift"].get<double>() << " % of "
              << error["path"].get<double>() << " m, ATE "
              << 100 * error["ate"]["rmse"].get<double>() << " cm\n"
              << built.out;
}

INSTANTIATE_TEST_SUITE_P(Shared, RealSequence, ::testing::ValuesIn(kSequences),
                         [](const auto& i) { return std::string(i.param.name); });

}  // namespace
}  // namespace superray
