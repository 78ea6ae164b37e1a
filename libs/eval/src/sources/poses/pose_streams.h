// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file pose_streams.h
/// What a recording says about robot poses, sorted by kind and label, in its own order.

#include <mrpt/core/Clock.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace superray {

/// Where an entry stands in a recording.
struct Place {
    mrpt::Clock::time_point time;
    std::uint64_t order = 0;  ///< number of the observation or action
    std::uint64_t group = 0;  ///< number of the object that holds it (a frame holds many)

    /// MRPT's mark of a time that nobody knows.
    bool hasTime() const { return time != mrpt::Clock::time_point(); }
};

bool isFinite(const mrpt::poses::CPose3D& pose);

struct PoseEntry {
    Place place;
    mrpt::poses::CPose3D pose;
};

/// All poses of one kind and label.
struct PoseStream {
    std::vector<PoseEntry> entries;
    std::uint64_t notFinite = 0;  ///< poses that were dropped

    bool empty() const { return entries.empty(); }
    /// Drops, and counts, poses that are not finite.
    void add(const Place& place, const mrpt::poses::CPose3D& pose);
};

using PoseStreamsByLabel = std::map<std::string, PoseStream>;

struct PoseStreams {
    PoseStreamsByLabel robotPoses, odometry;
    PoseStream actions;              ///< sum of the increments so far
    std::uint64_t emptyActions = 0;  ///< collections that tell no movement
    bool actionsMove = false;        ///< whether any increment is not zero

    /// Takes robot poses and odometry; ignores other observations.
    void add(const mrpt::obs::CObservation& observation, const Place& place);
    /// \return false if the increment is not finite, so that no pose after it is known
    bool addAction(const mrpt::poses::CPose3D& increment, const Place& place);
};

/// A scan that needs a pose.
struct ScanPlace {
    Place place;
    unsigned sensor = 0;  ///< the same number for scans of the same sensor
};

}  // namespace superray
