// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file scan_poses.h
/// The decision which poses of a recording are used, in words too.

#include <superray/eval/pose_origin.h>
#include <superray/eval/scan_source.h>
#include <superray/maps/pose_track.h>

#include <cstdint>
#include <string>

#include "sources/poses/pose_assignment.h"

namespace superray {

/// The limits that the options ask for, of poses that are logged beside the scans.
PoseLimits poseLimits(const ScanSourceOptions& options);

/// Poses for the scans of one recording.
class ScanPoses {
 public:
    /// \param what names the recording in errors
    /// \throws InputError if the poses asked for are not there, or there are several and
    ///         none was asked for; the message lists what there is
    ScanPoses(const RecordedPoses& recorded, const ScanSourceOptions& options,
              const std::string& what);

    PoseAnswer at(const Place& scan) const;

    /// Poses by time; nullptr if they are by order, or the robot is fixed.
    const PoseTrack* track() const { return assigned_.byTime ? &assigned_.track : nullptr; }
    const PoseSummary& summary() const { return summary_; }
    /// Poses that were dropped from the chosen ones, as they were not finite.
    std::uint64_t notFinite() const { return notFinite_; }

 private:
    void decide(const RecordedPoses& recorded, const ScanSourceOptions& options,
                const std::string& what);
    void useFile(const RecordedPoses& recorded, const ScanSourceOptions& options);
    void use(const PoseCandidate& chosen, PoseAssignment assigned,
             const RecordedPoses& recorded);

    PoseLimits limits_;
    bool fixed_ = false;
    PoseAssignment assigned_;
    PoseSummary summary_;
    std::uint64_t notFinite_ = 0;
};

}  // namespace superray
