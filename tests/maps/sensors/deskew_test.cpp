// SPDX-License-Identifier: BSD-3-Clause
// Scans of a moving robot: each ray from where the sensor was at its time.

#include <mrpt/poses/CPose3DInterpolator.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/observation_rays.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cstring>
#include <iostream>

#include "maps/test_scans.h"
#if __has_include(<mrpt/maps/CPointsMapXYZIRT.h>)
#define SUPERRAY_TEST_HAS_XYZIRT
#include <mrpt/maps/CPointsMapXYZIRT.h>
#endif
#if __has_include(<mrpt/maps/CGenericPointsMap.h>)
#define SUPERRAY_TEST_HAS_GENERIC
#include <mrpt/maps/CGenericPointsMap.h>
#endif

namespace superray {
namespace {

using mrpt::poses::CPose3D;
using Velodyne = mrpt::obs::CObservationVelodyneScan;

/// 12 m/s forwards (and a little aside and upwards) in a curve of 80 degrees per
/// second, as formulas; the trajectory has knots of it.
struct Motion {
    Eigen::Vector3d start{3, -2, 0.5}, velocity{11, -4, 0.7};
    double yaw = 0.4, yawRate = 1.4, pitch = 0.1, roll = -0.05;

    Eigen::Matrix3d rotation(double t) const {
        return (Eigen::AngleAxisd(yaw + yawRate * t, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    }
    Eigen::Vector3d position(double t) const { return start + velocity * t; }
    CPose3D pose(double t) const {
        const Eigen::Vector3d p = position(t);
        return {p.x(), p.y(), p.z(), yaw + yawRate * t, pitch, roll};
    }
    /// Knots at irregular times from `first` to `last` [s] after `stamp`.
    mrpt::poses::CPose3DInterpolator knots(mrpt::Clock::time_point stamp, double first,
                                           double last) const {
        mrpt::poses::CPose3DInterpolator trajectory;
        const auto insert = [&](double t) {
            // The clock counts in 100 ns.
            const auto ticks = static_cast<std::int64_t>(std::llround(t * 1e7));
            trajectory.insert(stamp + mrpt::Clock::duration(ticks),
                              pose(static_cast<double>(ticks) * 1e-7));
        };
        for (double t = first; t < last; t += 0.007 + 0.004 * std::sin(50 * t)) insert(t);
        insert(last);
        return trajectory;
    }
};

/// Sensor on the robot as matrices, made from angles anew.
struct Mounting {
    Eigen::Vector3d at{0.2, -0.1, 1.1};
    Eigen::Matrix3d R = (Eigen::AngleAxisd(-0.4, Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(0.25, Eigen::Vector3d::UnitY()) *
                         Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitX()))
                            .toRotationMatrix();
    static CPose3D pose() { return {0.2, -0.1, 1.1, -0.4, 0.25, -0.2}; }
};

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

// From here on for versions of MRPT whose clouds have times.

/// A point of the map, and when the sensor saw it.
struct SeenPoint {
    Eigen::Vector3d p_map;
    float seconds;
};

/// A turn of the sensor, in the order of laser rings, which is not that of time; the time
/// stamp is in the middle of it.
[[maybe_unused]] std::vector<SeenPoint> seenPoints(const Motion& motion) {
    std::mt19937 random(31);
    std::uniform_real_distribution<double> range(2, 30), up(-0.3, 0.3);
    std::vector<SeenPoint> points;
    for (int i = 0; i < 3000; ++i) {
        const double turned = (i % 500) / 500.0, azimuth = 2 * M_PI * turned, r = range(random);
        points.push_back({motion.start + Eigen::Vector3d(r * std::cos(azimuth),
                                                         r * std::sin(azimuth), r * up(random)),
                          static_cast<float>(0.1 * turned - 0.05)});
    }
    return points;
}

/// The scan of a moving sensor: every point in the frame that the sensor then had.
/// \param addPoint (point in the sensor's frame, seconds)
template <class AddPoint>
void shear(const std::vector<SeenPoint>& points, const Motion& motion, AddPoint addPoint) {
    const Mounting mounting;
    for (const SeenPoint& point : points) {
        const double t = double{point.seconds};
        const Eigen::Vector3d p_robot =
            motion.rotation(t).transpose() * (point.p_map - motion.position(t));
        const Eigen::Vector3d p_sensor = mounting.R.transpose() * (p_robot - mounting.at);
        addPoint(p_sensor.cast<float>(), point.seconds);
    }
}

[[maybe_unused]] void expectRestored(const mrpt::maps::CPointsMap::Ptr& sheared,
                                     const std::vector<SeenPoint>& points,
                                     const Motion& motion) {
    mrpt::obs::CObservationPointCloud scan;
    scan.timestamp = mrpt::Clock::now();
    scan.sensorPose = Mounting::pose();
    scan.pointcloud = sheared;
    const auto trajectory = motion.knots(scan.timestamp, -0.1, 0.1);
    const PoseAtTime poseAt = [&](mrpt::Clock::time_point time) {
        CPose3D pose;
        bool valid = false;
        trajectory.interpolate(time, pose, valid);
        return valid ? std::optional<CPose3D>(pose) : std::nullopt;
    };
    CSuperRayGridMap3D map(0.1);
    const auto returns = readReturns(scan, {1, false, 0, ReturnTimes::read, 0});
    ASSERT_TRUE(returns);
    ASSERT_EQ(returns->hits.size(), points.size());
    ASSERT_EQ(returns->hitTimes.size(), points.size());
    TInsertionReport report;
    const auto rays = toRaysAlong(*returns, scan.timestamp, poseAt, map.storage().geometry(),
                                  map.insertionOptions, report);
    ASSERT_EQ(rays.size(), points.size());
    EXPECT_EQ(report.withoutPose, 0u);
    double worstEnd = 0, worstOrigin = 0, skew = 0;
    const Mounting mounting;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double t = double{points[i].seconds};
        const Eigen::Vector3d origin = motion.position(t) + motion.rotation(t) * mounting.at;
        worstEnd = std::max(worstEnd, (rays.end(i) - points[i].p_map).norm());
        worstOrigin = std::max(worstOrigin, (rays.origin(i) - origin).norm());
        const Eigen::Vector3d still =
            motion.position(0) +
            motion.rotation(0) * (mounting.at + mounting.R * returns->hits[i].cast<double>());
        skew = std::max(skew, (still - points[i].p_map).norm());
    }
    std::cout << sheared->GetRuntimeClass()->className << " de-skewed: end points within "
              << worstEnd * 1e3 << " mm, origins " << worstOrigin * 1e3
              << " mm; not de-skewed, they are off by up to " << skew << " m\n";
    EXPECT_LT(worstEnd, 1e-3);
    EXPECT_LT(worstOrigin, 1e-3);
    EXPECT_GT(skew, 1.0) << "or the test would show nothing";
    // The map is made of these rays.
    CSuperRayGridMap3D direct(0.1);
    direct.insertRays(rays);
    ASSERT_TRUE(map.insertObservationAlong(scan, trajectory));
    EXPECT_EQ(map.digest(), direct.digest());
}

/// \param setTime (index, seconds)
template <class SetTime>
void expectNoPoseWithoutTime(const mrpt::maps::CPointsMap::Ptr& cloud, SetTime setTime) {
    const std::size_t size = cloud->size();
    setTime(0, std::numeric_limits<float>::quiet_NaN());
    setTime(1, std::numeric_limits<float>::infinity());
    setTime(2, -std::numeric_limits<float>::infinity());
    setTime(3, 1.7e9f);  // since 1970
    setTime(4, 3e19f);
    setTime(5, 1e7f);  // in nanoseconds
    mrpt::obs::CObservationPointCloud scan;
    scan.timestamp = mrpt::Clock::now();
    scan.pointcloud = cloud;
    CSuperRayGridMap3D map(0.1);
    ASSERT_TRUE(map.insertObservationAlong(scan, Motion().knots(scan.timestamp, -0.1, 0.1)));
    EXPECT_EQ(map.lastInsertion().withoutPose, 6u);
    EXPECT_EQ(map.lastInsertion().rays, size - 6);
    // Where times do not matter, these are points like others.
    CSuperRayGridMap3D still(0.1);
    ASSERT_TRUE(still.insertObservation(scan, CPose3D()));
    EXPECT_EQ(still.lastInsertion().rays, size);
}

#ifdef SUPERRAY_TEST_HAS_XYZIRT
TEST(Deskew, CloudsWithTimesAreRestored) {
    const Motion motion;
    const auto points = seenPoints(motion);
    auto cloud = mrpt::maps::CPointsMapXYZIRT::Create();
    cloud->resize_XYZIRT(points.size(), false, false, true);
    std::size_t i = 0;
    shear(points, motion, [&](const Eigen::Vector3f& p, float seconds) {
        cloud->setPointFast(i, p.x(), p.y(), p.z());
        cloud->setPointTime(i++, seconds);
    });
    expectRestored(cloud, points, motion);
    expectNoPoseWithoutTime(cloud, [&](std::size_t k, float t) { cloud->setPointTime(k, t); });
}

TEST(Deskew, CloudsWhoseClassHasTimesNeedNotHaveThem) {
    auto cloud = mrpt::maps::CPointsMapXYZIRT::Create();
    cloud->resize_XYZIRT(2, false, false, false);
    cloud->setPointFast(0, 1, 2, 3);
    cloud->setPointFast(1, 3, 2, 1);
    mrpt::obs::CObservationPointCloud scan;
    scan.pointcloud = cloud;
    const auto returns = readReturns(scan, {1, false, 0, ReturnTimes::read, 0});
    ASSERT_TRUE(returns);
    EXPECT_EQ(returns->hitTimes, std::vector<float>(2, 0.0f));
}
#endif

#ifdef SUPERRAY_TEST_HAS_GENERIC
TEST(Deskew, CloudsWithAChannelOfTimesAreRestored) {
    const Motion motion;
    const auto points = seenPoints(motion);
    auto cloud = mrpt::maps::CGenericPointsMap::Create();
    cloud->registerField_float("t");
    shear(points, motion, [&](const Eigen::Vector3f& p, float seconds) {
        cloud->insertPointFast(p.x(), p.y(), p.z());
        cloud->insertPointField_float("t", seconds);
    });
    expectRestored(cloud, points, motion);
    expectNoPoseWithoutTime(
        cloud, [&](std::size_t k, float t) { cloud->setPointField_float(k, "t", t); });
}
#endif

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
