// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file pose_assignment.h
/// Poses given to the scans of a recording, by time or by order.

#include <superray/maps/pose_track.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "sources/poses/pose_chooser.h"
#include "sources/poses/pose_streams.h"

namespace superray {

/// What a recording holds of poses and scans, in its order.
struct RecordedPoses {
    PoseStreams streams;
    std::vector<ScanPlace> scans;
};

struct PoseAssignment {
    bool byTime = false;
    PoseTrack track;  ///< of the scans that are not in byOrder, if byTime
    std::map<std::uint64_t, mrpt::poses::CPose3D> byOrder;  ///< by the scan's order

    PoseAnswer at(const Place& scan, const PoseLimits& limits) const;
    /// Scans that get a pose.
    std::uint64_t count(const std::vector<ScanPlace>& scans, const PoseLimits& limits) const;
};

/// The poses of one kind and label. By time, but by order where time stamps are invalid or
/// mostly equal, and among poses of the same time; actions always by order, but not beyond the
/// longest gap that is bridged.
/// \throws InputError, naming `what`, if the order does not tell, or two poses of one time
///         contradict each other
PoseAssignment assignPoses(const PoseCandidate& chosen, const std::vector<ScanPlace>& scans,
                           const PoseLimits& limits, const std::string& what);

/// Odometry or actions, fixed to the map by robot poses; see AnchoredMotion.
/// \param anchorsUsed how many robot poses are near the odometry in time; if none is, the
///        assignment gives no scan a pose
/// \throws InputError likewise
PoseAssignment assignAnchored(const PoseCandidate& anchors, const PoseCandidate& motion,
                              const std::vector<ScanPlace>& scans, const PoseLimits& limits,
                              const std::string& what, std::size_t& anchorsUsed);

}  // namespace superray
