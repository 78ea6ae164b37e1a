// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The scans of tests/data/formats/ros1 and ros2, as make_ros1_bags.py makes them, given as
// rawlogs.

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <string>

#include "eval/sources/format_samples.h"

namespace superray::test {

/// Where the sensors of the samples are on the robot.
inline CPose3D rosMount() {
    return CPose3D(0.25, 0, 0.5, 0.5, 0, 0);
}

inline mrpt::obs::CObservation::Ptr rosCloud(int scan) {
    auto cloud = sampleScan(scan);
    cloud->sensorPose = rosMount();
    return cloud;
}

inline mrpt::obs::CObservation::Ptr rosLaser(int scan) {
    constexpr int kRays = 65;
    auto laser = mrpt::obs::CObservation2DRangeScan::Create();
    laser->timestamp = at(1000 + 0.5 * scan);
    laser->aperture = 3;
    laser->maxRange = 8;
    laser->sensorPose = rosMount();
    laser->resizeScan(kRays);
    for (int i = 0; i < kRays; ++i) {
        const bool isNoReturn = i == 10 || i == 11, isUnknown = i > 11 && i < 15;
        const auto range = static_cast<float>(1 + ((i * 7 + scan * 3) % 32) / 8.0);
        laser->setScanRange(static_cast<std::size_t>(i), isNoReturn  ? 8.0f
                                                         : isUnknown ? 0.0f
                                                                     : range);
        laser->setScanRangeValidity(static_cast<std::size_t>(i), !isNoReturn);
    }
    return laser;
}

inline mrpt::obs::CObservation3DRangeScan::Ptr rosImage(int scan) {
    auto image = sampleImage(scan);
    image->rangeUnits = 0.001f;
    image->maxRange = 0;
    image->sensorPose = CPose3D(0.25, 0, 0.5, 0, 0, 0);
    for (int r = 0; r < 24; ++r)
        for (int c = 0; c < 32; ++c)
            image->rangeImage(r, c) =
                (r + c) % 7 == 0
                    ? std::uint16_t{0}
                    : static_cast<std::uint16_t>(1000 + 20 * r + 10 * c + 140 * scan);
    return image;
}

/// Its pixels as points, of depths in units of 1/1024 m.
inline mrpt::obs::CObservation::Ptr rosDepthPoints(int scan) {
    const auto image = rosImage(scan);
    auto points = mrpt::obs::CObservation3DRangeScan::Create();
    points->timestamp = image->timestamp;
    points->sensorPose = image->sensorPose;
    points->hasPoints3D = true;
    for (int r = 0; r < 24; ++r)
        for (int c = 0; c < 32; ++c) {
            const float depth = static_cast<float>(image->rangeImage(r, c)) / 1024.0f;
            if (depth == 0) continue;
            const auto metres = static_cast<double>(depth);
            points->points3D_idxs_x.push_back(static_cast<std::uint16_t>(c));
            points->points3D_idxs_y.push_back(static_cast<std::uint16_t>(r));
            points->points3D_x.push_back(depth);
            points->points3D_y.push_back(static_cast<float>(metres * (15.4 - c) / 30));
            points->points3D_z.push_back(static_cast<float>(metres * (11.6 - r) / 31));
        }
    return points;
}

/// The map of such scans at samplePose(), given as a rawlog.
template <class MakeScan>
std::string expectedRosDigest(const MakeScan& makeScan) {
    TempFolder folder;
    Objects objects;
    for (int i = 0; i < 3; ++i) {
        objects.push_back(makePose(1000 + 0.5 * i, samplePose(i)));
        objects.push_back(makeScan(i));
    }
    return build(writeRawlog(folder / "a.rawlog", objects)).digest;
}

/// What is asked of a recording of several sensors and poses.
inline ScanSourceOptions rosOptions(const std::string& sensor, const std::string& poses = "") {
    ScanSourceOptions options;
    options.sensorLabel = sensor;
    options.poseLabel = poses;
    return options;
}

}  // namespace superray::test
