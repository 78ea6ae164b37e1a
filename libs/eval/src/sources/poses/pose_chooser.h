// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file pose_chooser.h
/// Which of the poses in a recording may be used, by what was asked for.

#include <superray/eval/pose_origin.h>
#include <superray/eval/scan_source.h>

#include <optional>
#include <string>
#include <vector>

#include "sources/poses/pose_streams.h"

namespace superray {

/// Poses of one kind and label.
struct PoseCandidate {
    PoseOrigin kind;
    std::string label;
    const PoseStream* stream;

    /// E.g. "odometry 'wheels'".
    std::string name() const;
};

class PoseChooser {
 public:
    /// \throws InputError if the recording has no poses of a label in the options; the message
    ///         lists the labels that it has
    PoseChooser(const PoseStreams& streams, const ScanSourceOptions& options,
                const std::string& what);

    /// Robot poses; nothing if there are none, or others were asked for.
    /// \throws InputError if there are several labels and none was asked for
    std::optional<PoseCandidate> robotPoses() const;

    /// Odometry or actions, likewise: odometry if most actions tell no movement, or all
    /// say that the robot stood still.
    std::optional<PoseCandidate> motion() const;

    /// "robot poses 'amcl' (6), 'gps' (6); odometry 'wheels' (60)": all that there is.
    static std::string list(const PoseStreams& streams);

 private:
    bool asksFor(PoseOrigin kind) const;
    std::optional<PoseCandidate> only(PoseOrigin kind, const PoseStreamsByLabel& all) const;

    const PoseStreams& streams_;
    PoseOrigin origin_;
    std::vector<std::string> labels_;  // empty: any
    std::string what_;
};

}  // namespace superray
