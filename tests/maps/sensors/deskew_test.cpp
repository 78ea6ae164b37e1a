// SPDX-License-Identifier: BSD-3-Clause
// Scans of a moving robot: each ray from where the sensor was at its time.

#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/observation_rays.h>

#include <cstring>
#include <iostream>

#include "maps/sensors/motion.h"
#include "maps/test_scans.h"

namespace superray {
namespace {

using namespace test;
using Velodyne = mrpt::obs::CObservationVelodyneScan;

struct Return {
    double seconds;  ///< after the first packet
    Eigen::Vector3d p_sensor;
};

unsigned number(const std::uint8_t* bytes, int count) {
    unsigned v = 0;
    for (int i = count - 1; i >= 0; --i) v = v << 8 | bytes[i];
    return v;
}

/// The packets by the manual of the VLP-16, from their bytes, single return.
std::vector<Return> decodeVlp16(const Velodyne& scan) {
    std::vector<Return> returns;
    double firstStamp = -1;
    for (const auto& packet : scan.scan_packets) {
        std::array<std::uint8_t, 1206> bytes;
        std::memcpy(bytes.data(), &packet, bytes.size());
        const double stamp = number(bytes.data() + 1200, 4) * 1e-6;
        if (firstStamp < 0) firstStamp = stamp;
        std::array<double, 12> azimuth;  // degrees
        for (std::size_t b = 0; b < 12; ++b)
            azimuth[b] = number(bytes.data() + 100 * b + 2, 2) / 100.0;
        // Turn per block: the median, so that a gap in the packet does not count.
        std::vector<double> turns;
        for (std::size_t b = 0; b + 1 < 12; ++b)
            turns.push_back(std::fmod(azimuth[b + 1] - azimuth[b] + 360, 360));
        std::sort(turns.begin(), turns.end());
        const double turn = turns[turns.size() / 2];
        for (std::size_t b = 0; b < 12; ++b)
            for (int firing = 0; firing < 2; ++firing)
                for (int laser = 0; laser < 16; ++laser) {
                    const auto* at = bytes.data() + 100 * b + 4 + 48 * firing + 3 * laser;
                    const double range = number(at, 2) * 0.002;
                    if (range < scan.minRange || range > scan.maxRange) continue;
                    const double inBlock = (55.296 * firing + 2.304 * laser) * 1e-6;
                    const double clockwise =
                        (azimuth[b] + turn * inBlock / 110.592e-6) * M_PI / 180;
                    const double up = (laser % 2 == 0 ? laser - 15 : laser) * M_PI / 180;
                    returns.push_back(
                        {stamp - firstStamp + 110.592e-6 * static_cast<double>(b) + inBlock,
                         range * Eigen::Vector3d(std::cos(up) * std::cos(clockwise),
                                                 -std::cos(up) * std::sin(clockwise),
                                                 std::sin(up))});
                }
    }
    return returns;
}

Velodyne::Ptr vlp16Scan() {
    auto scan = std::dynamic_pointer_cast<Velodyne>(
        test::readScans(test::mrptDataset("test_velodyne_VLP16.rawlog"), 1).at(0).scan);
    scan->sensorPose = Mounting::pose();
    return scan;
}

TEST(Deskew, Vlp16EndPointsAreWithinAMillimetreOfAnIndependentComputation) {
    SUPERRAY_SKIP_WITHOUT(test::mrptDataset("test_velodyne_VLP16.rawlog"));
    const auto scan = vlp16Scan();
    const Motion motion;
    const Mounting mounting;
    const auto expected = decodeVlp16(*scan);
    ASSERT_EQ(expected.size(), 22591u);
    EXPECT_NEAR(expected.back().seconds, 0.1, 0.01) << "a turn of the sensor";

    CSuperRayGridMap3D map(0.1);
    const auto trajectory = motion.knots(scan->timestamp, -0.01, 0.2);
    const PoseAtTime poseAt = [&](mrpt::Clock::time_point time) {
        CPose3D pose;
        bool valid = false;
        trajectory.interpolate(time, pose, valid);
        return valid ? std::optional<CPose3D>(pose) : std::nullopt;
    };
    TInsertionReport report;
    const auto returns = readReturns(*scan, {1, false, 0, ReturnTimes::read, 0});
    ASSERT_TRUE(returns);
    ASSERT_EQ(returns->hitTimes.size(), returns->hits.size());
    const auto rays = toRaysAlong(*returns, scan->timestamp, poseAt, map.storage().geometry(),
                                  map.insertionOptions, report);
    ASSERT_EQ(rays.size(), expected.size());
    EXPECT_EQ(report.withoutPose, 0u);
    double worstEnd = 0, worstOrigin = 0, skew = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const double t = expected[i].seconds;
        const Eigen::Matrix3d R = motion.rotation(t);
        const Eigen::Vector3d origin = motion.position(t) + R * mounting.at;
        const Eigen::Vector3d end =
            motion.position(t) + R * (mounting.at + mounting.R * expected[i].p_sensor);
        worstEnd = std::max(worstEnd, (rays.end(i) - end).norm());
        worstOrigin = std::max(worstOrigin, (rays.origin(i) - origin).norm());
        const Eigen::Vector3d still =
            motion.position(0) +
            motion.rotation(0) * (mounting.at + mounting.R * expected[i].p_sensor);
        skew = std::max(skew, (end - still).norm());
    }
    std::cout << "VLP-16 de-skewed: end points within " << worstEnd * 1e3 << " mm, origins "
              << worstOrigin * 1e3 << " mm; not de-skewed, they are off by up to " << skew
              << " m\n";
    EXPECT_LT(worstEnd, 1e-3);
    EXPECT_LT(worstOrigin, 1e-3);
    EXPECT_GT(skew, 1.0) << "or the test would show nothing";

    // The map is made of these rays.
    CSuperRayGridMap3D direct(0.1), still(0.1);
    direct.insertRays(rays);
    ASSERT_TRUE(map.insertObservationAlong(*scan, poseAt));
    EXPECT_EQ(map.digest(), direct.digest());
    EXPECT_EQ(map.lastInsertion().rays, expected.size());
    ASSERT_TRUE(still.insertObservation(*scan, motion.pose(0)));
    EXPECT_NE(map.digest(), still.digest());
}

TEST(Deskew, RobotAtRestGivesTheSameMap) {
    SUPERRAY_SKIP_WITHOUT(test::mrptDataset("test_velodyne_VLP16.rawlog"));
    const auto scan = vlp16Scan();
    mrpt::poses::CPose3DInterpolator rest;
    for (const int tenths : {-1, 2, 4})
        rest.insert(scan->timestamp + std::chrono::milliseconds(100 * tenths),
                    test::someRobotPose());
    CSuperRayGridMap3D along(0.1), at(0.1);
    along.insertionOptions.insertNoReturnRays = at.insertionOptions.insertNoReturnRays = true;
    along.insertionOptions.noReturnRange = at.insertionOptions.noReturnRange = 5;
    ASSERT_TRUE(along.insertObservationAlong(*scan, rest));
    ASSERT_TRUE(at.insertObservation(*scan, test::someRobotPose()));
    EXPECT_EQ(along.lastInsertion().rays, at.lastInsertion().rays);
    EXPECT_GT(along.lastInsertion().noReturns, 6000u);
    // Interpolation rounds: a few end points may change their cell.
    const double occupied = static_cast<double>(at.cellTotals().occupied);
    EXPECT_NEAR(static_cast<double>(along.cellTotals().occupied), occupied, 0.002 * occupied);
}

TEST(Deskew, RaysOutsideTheTrajectoryAreLeftOutAndCounted) {
    SUPERRAY_SKIP_WITHOUT(test::mrptDataset("test_velodyne_VLP16.rawlog"));
    const auto scan = vlp16Scan();
    CSuperRayGridMap3D map(0.1);
    const auto half = Motion().knots(scan->timestamp, -0.01, 0.05);
    ASSERT_TRUE(map.insertObservationAlong(*scan, half));
    const auto& report = map.lastInsertion();
    EXPECT_EQ(report.rays + report.withoutPose, 22591u);
    EXPECT_GT(report.withoutPose, 9000u);
    EXPECT_GT(report.rays, 9000u);
    const auto digest = map.digest();
    EXPECT_FALSE(map.insertObservationAlong(*scan, Motion().knots(scan->timestamp, 1, 2)));
    EXPECT_EQ(map.lastInsertion().withoutPose, 22591u);
    EXPECT_FALSE(map.insertObservationAlong(*scan, mrpt::poses::CPose3DInterpolator()));
    map.genericMapParams.enableObservationInsertion = false;
    EXPECT_FALSE(map.insertObservationAlong(*scan, half));
    EXPECT_EQ(map.digest(), digest);
}

TEST(Deskew, PlanarScansTakeTheSweepDuration) {
    auto scan = test::planarScan(91);
    scan->timestamp = mrpt::Clock::now();
    const Motion motion;
    const auto trajectory = motion.knots(scan->timestamp, -0.02, 0.2);
    const auto returns = readReturns(*scan, {1, true, 4.0, ReturnTimes::read, 0.09});
    ASSERT_TRUE(returns);
    ASSERT_EQ(returns->hits.size(), 45u);
    ASSERT_EQ(returns->noReturns.size(), 46u);
    ASSERT_EQ(returns->hitTimes.size(), 45u);
    ASSERT_EQ(returns->noReturnTimes.size(), 46u);
    for (std::size_t i = 0; i < 45; ++i)
        EXPECT_NEAR(returns->hitTimes[i], 0.001 * static_cast<double>(2 * i + 1), 1e-7);
    for (std::size_t i = 0; i < 46; ++i)
        EXPECT_NEAR(returns->noReturnTimes[i], 0.001 * static_cast<double>(2 * i), 1e-7);

    CSuperRayGridMap3D map(0.05), still(0.05);
    map.insertionOptions.sweepDuration = 0.09;
    ASSERT_TRUE(map.insertObservationAlong(*scan, trajectory));
    for (int i = 1; i < 91; i += 2) {
        const double angle = M_PI / 2 * (i / 90.0 - 0.5), t = 0.001 * i;
        const Eigen::Vector3d p_robot =
            Eigen::Vector3d(0.3, 0.1, 0.4) +
            Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()) *
                Eigen::Vector3d(3 * std::cos(angle), 3 * std::sin(angle), 0);
        const Eigen::Vector3d end = motion.position(t) + motion.rotation(t) * p_robot;
        const auto value = map.storage().logOdds(map.storage().geometry().cellOf(end));
        ASSERT_TRUE(value) << i;
        EXPECT_GT(*value, 0) << i;
    }
    // Without the option all rays are of one time.
    ASSERT_TRUE(still.insertObservationAlong(*scan, trajectory));
    CSuperRayGridMap3D plain(0.05);
    ASSERT_TRUE(plain.insertObservation(*scan, motion.pose(0)));
    EXPECT_EQ(still.cellTotals().occupied, plain.cellTotals().occupied);
    EXPECT_NE(still.digest(), map.digest());
}

}  // namespace
}  // namespace superray