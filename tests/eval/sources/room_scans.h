// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file room_scans.h
/// A robot with a laser that drives half a metre a second through a room, and the map
/// that a recording of it gives.

#include <mrpt/obs/CObservation2DRangeScan.h>
#include <superray/eval/map_build.h>
#include <superray/maps/CSuperRayGridMap2D.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "eval/recorded_scans.h"

namespace superray::test {

/// Where small recordings of users are that were made for this project.
inline std::string casePath(const std::string& name) {
    return std::string(SUPERRAY_SHARED_DATA_DIR) + "/../cases/" + name;
}

/// Half a circle of rays that end at the walls x = 8, y = 2 and y = -2.
inline mrpt::obs::CObservation2DRangeScan::Ptr roomScan(double seconds, double x,
                                                        const std::string& label = "LASER") {
    constexpr int kRays = 181;
    auto scan = mrpt::obs::CObservation2DRangeScan::Create();
    scan->timestamp = at(seconds);
    scan->sensorLabel = label;
    scan->aperture = static_cast<float>(M_PI);
    scan->maxRange = 30;
    scan->resizeScan(kRays);
    for (int i = 0; i < kRays; ++i) {
        const double angle = M_PI * (i / (kRays - 1.0) - 0.5);
        const double side = std::abs(2 / std::sin(angle)), ahead = (8 - x) / std::cos(angle);
        scan->setScanRange(static_cast<std::size_t>(i),
                           static_cast<float>(std::min(side, ahead)));
        scan->setScanRangeValidity(static_cast<std::size_t>(i), true);
    }
    return scan;
}

/// The robot's place at a time of the drive.
inline double driveX(double seconds) {
    return 0.5 * seconds;
}

/// What build makes of a recording.
struct BuiltMap {
    std::string digest, poses;
    BuildReport report;
    std::shared_ptr<CSuperRayGridMap2D> map;
};

inline BuiltMap buildPlan(const std::string& path, const ScanSourceOptions& options = {}) {
    ScanSources sources;
    sources.push_back(openScanSource(path, options));
    BuiltMap built;
    built.map = std::make_shared<CSuperRayGridMap2D>(0.1);
    built.report = buildMap(sources, *built.map, std::numeric_limits<std::uint64_t>::max(),
                            [](const BuildProgress&) {});
    built.digest = built.map->digest();
    built.poses = built.report.poses.front();
    return built;
}

/// Without time stamps, as old recordings are.
inline Objects withoutTimes(Objects objects) {
    for (const auto& object : objects)
        if (auto o = std::dynamic_pointer_cast<mrpt::obs::CObservation>(object))
            o->timestamp = mrpt::Clock::time_point();
    return objects;
}

}  // namespace superray::test
