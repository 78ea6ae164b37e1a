// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file trajectory.h
/// Robot poses over time: read from text, asked for at any time in between.

#include <mrpt/core/Clock.h>
#include <mrpt/poses/CPose3D.h>

#include <cstddef>
#include <map>
#include <optional>
#include <string>

namespace superray {

/// Robot poses in the map frame, ordered by time.
class Trajectory {
 public:
    using Time = mrpt::Clock::time_point;

    /// Reads a text file of one pose a line, in one of two forms:
    ///  - TUM, 8 columns: `t x y z qx qy qz qw`;
    ///  - MRPT (CPose3DInterpolator), 7 columns: `t x y z yaw pitch roll`.
    /// t in seconds since 1970, metres, radians. Empty lines and lines starting
    /// with # or % are skipped; the lines may be in any order.
    /// \throws InputError naming file, line and rule
    static Trajectory load(const std::string& path);

    /// A later pose at the same time replaces the earlier one.
    void add(Time time, const mrpt::poses::CPose3D& T_map_robot);

    /// The robot pose in the map frame at `time`: the stored one if its time is
    /// within a microsecond (what text files lose), else interpolated between
    /// its neighbours (straight line; shortest rotation at constant rate).
    /// \param slack up to this long [s] before the first or after the last
    ///        pose, that pose is returned
    /// \return nothing outside the time range
    std::optional<mrpt::poses::CPose3D> at(Time time, double slack = 0) const;

    /// Writes TUM text (8 columns, see load()), by the rules of AtomicFile.
    /// \throws MapFileError
    void saveTum(const std::string& path) const;

    /// All poses by time.
    const std::map<Time, mrpt::poses::CPose3D>& poses() const { return poses_; }

    bool empty() const { return poses_.empty(); }
    std::size_t size() const { return poses_.size(); }
    Time firstTime() const { return poses_.begin()->first; }  ///< \pre !empty()
    Time lastTime() const { return poses_.rbegin()->first; }  ///< \pre !empty()

 private:
    std::map<Time, mrpt::poses::CPose3D> poses_;
};

}  // namespace superray
