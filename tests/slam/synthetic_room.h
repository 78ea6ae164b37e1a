// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A room of 8 m x 6 m x 3 m with a cupboard, seen by a rotating lidar.

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/poses/CPose3D.h>
#include <superray/eval/scan_source.h>
#include <superray/maps/observation_rays.h>

#include <cmath>
#include <limits>
#include <random>

namespace superray::test {

inline const mrpt::poses::CPose3D& lidarOnRobot() {
    static const mrpt::poses::CPose3D pose(0.2, -0.1, 0.8, 0.3, 0.05, -0.02);
    return pose;
}

/// Distance along a ray from inside a box to its wall, or from outside to it.
inline double distanceToBox(const Eigen::Vector3d& o, const Eigen::Vector3d& d,
                            const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                            bool inside) {
    double enter = -std::numeric_limits<double>::infinity(),
           leave = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
        const double t1 = (low[a] - o[a]) / d[a], t2 = (high[a] - o[a]) / d[a];
        enter = std::max(enter, std::min(t1, t2));
        leave = std::min(leave, std::max(t1, t2));
    }
    if (inside) return leave;
    return enter <= leave && enter > 0 ? enter : std::numeric_limits<double>::infinity();
}

inline double distanceInRoom(const Eigen::Vector3d& o, const Eigen::Vector3d& d) {
    const double walls = distanceToBox(o, d, {-4.02, -3.03, -0.01}, {4.05, 3.01, 2.96}, true);
    return std::min(walls, distanceToBox(o, d, {2.1, 1.2, -1}, {3.3, 4, 1.7}, false));
}

/// 32 rings of 360 points with 1 cm noise.
inline Scan roomScan(const mrpt::poses::CPose3D& T_map_robot, double seconds,
                     std::uint32_t seed) {
    const mrpt::poses::CPose3D T_map_sensor = T_map_robot + lidarOnRobot();
    const Eigen::Matrix3d R = T_map_sensor.getRotationMatrix().asEigen();
    const Eigen::Vector3d o(T_map_sensor.x(), T_map_sensor.y(), T_map_sensor.z());
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, 0.01);
    auto cloud = mrpt::obs::CObservationPointCloud::Create();
    cloud->sensorLabel = "LIDAR";
    cloud->timestamp = mrpt::Clock::fromDouble(1e9 + seconds);
    cloud->sensorPose = lidarOnRobot();
    cloud->pointcloud = mrpt::maps::CSimplePointsMap::Create();
    for (int ring = 0; ring < 32; ++ring)
        for (int i = 0; i < 360; ++i) {
            const double up = (-30 + 60.0 * ring / 31) * M_PI / 180, around = i * M_PI / 180;
            const Eigen::Vector3d d(std::cos(up) * std::cos(around),
                                    std::cos(up) * std::sin(around), std::sin(up));
            const Eigen::Vector3f p =
                ((distanceInRoom(o, R * d) + noise(random)) * d).cast<float>();
            cloud->pointcloud->insertPoint(p.x(), p.y(), p.z());
        }
    return {cloud->timestamp, T_map_robot, cloud};
}

/// A walk through the room; starts at the origin, level, looking along x.
inline mrpt::poses::CPose3D roomPose(int i) {
    const double s = 0.05 * i;
    return {1.5 * std::sin(s), 1.2 * (1 - std::cos(s)), 0.02 * std::sin(3 * s),
            0.9 * s,           0.03 * std::sin(2 * s),  0.02 * std::sin(s)};
}

inline SensorReturns returnsOf(const Scan& scan) {
    return readReturns(*scan.observation, {}).value();
}

}  // namespace superray::test
