// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file pose_origin.h
/// Where the robot poses of a recording come from: what may be asked for, and what was
/// decided.

#include <cstdint>
#include <string>
#include <utility>

namespace superray {

/// Where robot poses come from.
enum class PoseOrigin : std::uint8_t {
    /// Decided by what the input holds. Rawlogs and ROS: robot poses if they reach all scans;
    /// else odometry or actions, fixed to the map by robot poses if there are any.
    input,
    file,        ///< ScanSourceOptions::posesFile, by time
    fixed,       ///< the robot stays at the map's origin: one scan, or a fixed sensor
    robotPoses,  ///< CObservationRobotPose of one label (rawlogs); see openScanSource() (ROS)
    odometry,    ///< CObservationOdometry of one label (rawlogs); likewise
    actions,     ///< the sum of the actions' mean increments (rawlogs)
    motion       ///< actions, or odometry: nothing that needs a map (rawlogs, ROS)
};

/// "auto", "file", "fixed", "poses", "odometry", "actions" or "motion".
const char* toString(PoseOrigin origin);
/// \throws std::invalid_argument naming the value and what is allowed
PoseOrigin poseOriginFromString(const std::string& name);

/// The poses that were decided on.
struct PoseSummary {
    PoseSummary() = default;
    /// Without times.
    explicit PoseSummary(std::string poses, std::uint64_t number = 0)
        : source(std::move(poses)), count(number) {}

    std::string source;          ///< e.g. "odometry 'wheels'"; empty: nothing to tell
    std::uint64_t count = 0;     ///< poses in it
    bool timed = false;          ///< whether the following two are known
    double first = 0, last = 0;  ///< [s] after the first time stamp of the input
    std::string note;            ///< e.g. that it is fixed to the map by robot poses

    void setTimes(double firstSeconds, double lastSeconds) {
        timed = true;
        first = firstSeconds;
        last = lastSeconds;
    }

    /// E.g. "odometry 'wheels', 6, 0.0 to 5.0 s".
    std::string asText() const;
};

}  // namespace superray
