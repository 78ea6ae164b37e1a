// SPDX-License-Identifier: BSD-3-Clause
// Point clouds with times, taken by a moving robot: each ray from where the sensor was.

#include <mrpt/obs/CObservationPointCloud.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/observation_rays.h>
#include <superray/maps/pose_track.h>

#include <gtest/gtest.h>

#include <iostream>
#include <random>

#include "maps/sensors/motion.h"
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

using namespace test;

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
    PoseTrack track;
    for (const auto& [time, pose] : trajectory) track.add(time, CPose3D(pose));
    const PoseAtTime poseAt = [&](mrpt::Clock::time_point time) { return track.at(time); };
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
// Deprecated since 2.15, but recordings have it.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
TEST(DeskewClouds, CloudsWithTimesAreRestored) {
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

TEST(DeskewClouds, CloudsWhoseClassHasTimesNeedNotHaveThem) {
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
#pragma GCC diagnostic pop
#endif

#ifdef SUPERRAY_TEST_HAS_GENERIC
TEST(DeskewClouds, CloudsWithAChannelOfTimesAreRestored) {
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

#if !defined(SUPERRAY_TEST_HAS_XYZIRT) && !defined(SUPERRAY_TEST_HAS_GENERIC)
TEST(DeskewClouds, CloudsHaveTimes) {
    GTEST_SKIP() << "this version of MRPT has no clouds with times";
}
#endif

}  // namespace
}  // namespace superray
