// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file trajectory.h
/// Robot poses over time as text.

#include <superray/maps/pose_track.h>

#include <string>

namespace superray {

/// A track of robot poses that comes from text, or goes there.
class Trajectory : public PoseTrack {
 public:
    /// Reads a text file of one pose a line, in one of two forms:
    ///  - TUM, 8 columns: `t x y z qx qy qz qw`;
    ///  - MRPT (CPose3DInterpolator), 7 columns: `t x y z yaw pitch roll`.
    /// t in seconds since 1970, metres, radians. Empty lines and lines starting
    /// with # or % are skipped; the lines may be in any order.
    /// \throws InputError naming file, line and rule
    static Trajectory load(const std::string& path);

    /// Writes TUM text (8 columns, see load()), by the rules of AtomicFile.
    /// \throws MapFileError
    void saveTum(const std::string& path) const;
};

}  // namespace superray
