// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file trajectory.h
/// Robot poses over time as text.

#include <superray/maps/pose_track.h>

#include <cstdint>
#include <string>

namespace superray {

/// A track of robot poses that comes from text, or goes there.
class Trajectory : public PoseTrack {
 public:
    /// Reads a text file of one pose a line, in one of three forms:
    ///  - TUM, 8 columns: `t x y z qx qy qz qw`;
    ///  - MRPT (CPose3DInterpolator), 7 columns: `t x y z yaw pitch roll`;
    ///  - MulRan, 13 columns: t [ns], then a 3x4 matrix, row by row.
    /// t in seconds since 1970, metres, radians; columns are separated by blanks, commas or
    /// semicolons. Empty lines, lines starting with # or %, and a heading without any number
    /// are skipped, but must not name another order of columns; the lines may be in any
    /// order, and be there twice. Rows with numbers that are not finite are skipped and
    /// counted.
    /// \throws InputError naming file, line and rule
    static Trajectory load(const std::string& path);

    /// Rows of the file that were not finite.
    std::uint64_t skippedRows() const { return skippedRows_; }

    /// Writes TUM text (8 columns, see load()), by the rules of AtomicFile.
    /// \throws MapFileError
    void saveTum(const std::string& path) const;

 private:
    std::uint64_t skippedRows_ = 0;
};

}  // namespace superray
