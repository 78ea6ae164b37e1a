// SPDX-License-Identifier: BSD-3-Clause
// Scans whose angles, and robots whose poses, are no sensible numbers.

#include <mrpt/obs/CObservationRotatingScan.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>

#include <cmath>
#include <functional>
#include <limits>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// In all ways that a map reads a scan.
void expectRefused(const mrpt::obs::CObservation& scan, const std::string& value,
                   const std::string& rule) {
    CSuperRayGridMap2D map(0.1);
    const auto alongNothing = [](mrpt::Clock::time_point) {
        return std::optional<CPose3D>(CPose3D());
    };
    const std::function<void()> ways[] = {
        [&] { map.insertObservation(scan, CPose3D()); },
        [&] { map.insertObservationAlong(scan, alongNothing); },
        [&] { map.computeObservationLikelihood(scan, CPose3D()); }};
    for (const auto& way : ways) {
        const std::string message = test::messageOf(way);
        EXPECT_CONTAINS(message, value);
        EXPECT_CONTAINS(message, rule);
    }
    EXPECT_TRUE(map.isEmpty());
    EXPECT_EQ(map.totals().scans, 0u);
}

TEST(OddScans, AperturesThatAreNoAnglesAreRefused) {
    auto scan = test::planarScan();
    const std::string rule = "must be from 0 to 2 pi";
    const std::pair<double, std::string> wrong[] = {{270, "aperture = 270"},
                                                    {6.3, "aperture = 6.3"},
                                                    {-1.5, "aperture = -1.5"},
                                                    {kNan, "aperture = nan"},
                                                    {kInf, "aperture = inf"}};
    for (const auto& [aperture, value] : wrong) {
        scan->aperture = static_cast<float>(aperture);
        expectRefused(*scan, value, rule);
    }
    for (const float aperture : {0.0f, 3.0f, static_cast<float>(2 * M_PI), 6.2832f, 6.29f}) {
        scan->aperture = aperture;
        CSuperRayGridMap2D map(0.1);
        EXPECT_TRUE(map.insertObservation(*scan, CPose3D())) << aperture;
    }
}

TEST(OddScans, AzimuthsThatAreNoAnglesAreRefused) {
    mrpt::obs::CObservationRotatingScan scan;
    scan.rowCount = 1;
    scan.columnCount = 5;
    scan.rangeImage.setSize(1, 5);
    scan.rangeImage.fill(200);
    scan.rangeResolution = 0.01;
    scan.maxRange = 20;
    for (const double span : {-2 * M_PI, -1.0, 0.0, 2 * M_PI}) {
        scan.azimuthSpan = span;
        CSuperRayGridMap2D map(0.1);
        EXPECT_TRUE(map.insertObservation(scan, CPose3D())) << span;
    }
    const std::string rule = "must be from -2 pi to 2 pi";
    for (const auto& [span, value] : {std::pair{360.0, "azimuthSpan = 360"},
                                      {-270.0, "azimuthSpan = -270"},
                                      {kNan, "azimuthSpan = nan"}}) {
        scan.azimuthSpan = span;
        expectRefused(scan, value, rule);
    }
    scan.azimuthSpan = 1;
    scan.startAzimuth = kNan;
    expectRefused(scan, "startAzimuth = nan", "must be finite");
}

/// Every second pose is not finite.
class OddPoses : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(FirstOrSecond, OddPoses, ::testing::Values(0, 1));

TEST_P(OddPoses, AreNoPosesWhereverTheyAre) {
    auto scan = test::planarScan(90);
    scan->resizeScanAndAssign(90, 3.0f, true);
    scan->timestamp = mrpt::Clock::now();
    for (const CPose3D& odd : {CPose3D(kNan, 0, 0, 0, 0, 0), CPose3D(0, kInf, 0, 0, 0, 0),
                               CPose3D(0, 0, 0, kNan, 0, 0)}) {
        CSuperRayGridMap3D map(0.1);
        map.insertionOptions.sweepDuration = 0.1;
        int asked = GetParam();
        const auto poseAt = [&](mrpt::Clock::time_point) {
            return std::optional<CPose3D>(asked++ % 2 == 0 ? odd : CPose3D());
        };
        EXPECT_TRUE(map.insertObservationAlong(*scan, poseAt));
        EXPECT_EQ(map.lastInsertion().rays, 45u);
        EXPECT_EQ(map.lastInsertion().withoutPose, 45u);
        EXPECT_EQ(map.lastInsertion().skipped.notFinite, 0u);
    }
}

TEST(OddPosesOfAScan, NothingIsInsertedWithoutAFiniteOne) {
    auto scan = test::planarScan(90);
    CSuperRayGridMap3D map(0.1);
    EXPECT_FALSE(map.insertObservationAlong(*scan, [](mrpt::Clock::time_point) {
        return std::optional<CPose3D>(CPose3D(kNan, 0, 0, 0, 0, 0));
    }));
    EXPECT_EQ(map.lastInsertion().withoutPose, 45u);
    EXPECT_TRUE(map.isEmpty());
}

}  // namespace
}  // namespace superray
