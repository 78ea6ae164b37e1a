// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file recorded_scans.h
/// Small recordings made by the tests: known points, known poses.

#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/io/CFileOutputStream.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/serialization/CArchive.h>

#include <random>
#include <vector>

namespace superray::test {

using Objects = std::vector<mrpt::serialization::CSerializable::Ptr>;

inline mrpt::Clock::time_point at(double seconds) {
    return mrpt::Clock::fromDouble(seconds);
}

/// A cloud of `count` seeded random points in a 10 m cube about the sensor.
inline mrpt::obs::CObservationPointCloud::Ptr makeCloud(double seconds, unsigned seed,
                                                        const std::string& label = "LIDAR",
                                                        int count = 50) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> coordinate(-5, 5);
    auto cloud = mrpt::obs::CObservationPointCloud::Create();
    cloud->timestamp = at(seconds);
    cloud->sensorLabel = label;
    cloud->sensorPose = mrpt::poses::CPose3D(0.1, -0.2, 0.5, 0.3, 0.2, -0.1);
    auto points = mrpt::maps::CSimplePointsMap::Create();
    for (int i = 0; i < count; ++i) {
        const float x = coordinate(random), y = coordinate(random), z = coordinate(random);
        points->insertPoint(x, y, z);
    }
    cloud->pointcloud = points;
    return cloud;
}

inline mrpt::obs::CObservationRobotPose::Ptr makePose(double seconds,
                                                      const mrpt::poses::CPose3D& pose) {
    auto observation = mrpt::obs::CObservationRobotPose::Create();
    observation->timestamp = at(seconds);
    observation->sensorLabel = "POSE";
    observation->pose.mean = pose;
    return observation;
}

inline mrpt::obs::CObservationOdometry::Ptr makeOdometry(double seconds,
                                                         const mrpt::poses::CPose2D& pose) {
    auto observation = mrpt::obs::CObservationOdometry::Create();
    observation->timestamp = at(seconds);
    observation->sensorLabel = "ODOMETRY";
    observation->odometry = pose;
    return observation;
}

/// Writes objects one after the other; Stream decides on compression.
template <class Stream = mrpt::io::CFileGZOutputStream>
std::string writeRawlog(const std::string& path, const Objects& objects) {
    Stream file;
    if (!file.open(path)) throw std::runtime_error("cannot write " + path);
    auto archive = mrpt::serialization::archiveFrom(file);
    for (const auto& object : objects) archive << *object;
    return path;
}

/// Coordinates of the points of a cloud observation, x y z x y z ...
inline std::vector<float> pointsOf(const mrpt::obs::CObservation& observation) {
    const auto& cloud = dynamic_cast<const mrpt::obs::CObservationPointCloud&>(observation);
    std::vector<float> result;
    for (std::size_t i = 0; i < cloud.pointcloud->size(); ++i) {
        float x, y, z;
        cloud.pointcloud->getPoint(i, x, y, z);
        result.insert(result.end(), {x, y, z});
    }
    return result;
}

}  // namespace superray::test
