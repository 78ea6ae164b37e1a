// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file pose_track.h
/// Robot poses over time, asked for at any time in between.

#include <mrpt/core/Clock.h>
#include <mrpt/poses/CPose3D.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

namespace superray {

/// Longest time between two poses that is bridged unless something else is asked for [s].
/// Within it a robot that drives at 1 m/s and turns at 0.3 rad/s leaves the straight line
/// between the poses by 15 cm; after longer times it may have been anywhere.
inline constexpr double kDefaultPoseGap = 2.0;

/// How far poses are trusted beyond their own times.
struct PoseLimits {
    /// [s] two poses that are farther apart are not interpolated
    double maxGap = std::numeric_limits<double>::infinity();
    /// [s] a pose holds for so long before the first, after the last, and into a gap
    double slack = 0;
};

/// The pose at a time, or why there is none.
struct PoseAnswer {
    enum class Result : std::uint8_t {
        found,
        outside,  ///< before the first pose, or after the last
        inGap     ///< between two poses that are too far apart
    };
    Result result = Result::outside;
    std::optional<mrpt::poses::CPose3D> pose;  ///< set if found
};

/// Pose at `fraction` of the way from a to b: straight line, and the shortest rotation
/// at constant rate.
mrpt::poses::CPose3D interpolatePose(const mrpt::poses::CPose3D& a,
                                     const mrpt::poses::CPose3D& b, double fraction);

/// A robot pose in the map frame and its time.
using TimedPose = std::pair<const mrpt::Clock::time_point, mrpt::poses::CPose3D>;

/// The pose at `time`: the one before or after if its time is within a microsecond (what text
/// files lose), else interpolatePose() of both.
/// \param before the last pose before `time`, after: the first one from then on; nullptr: none
PoseAnswer poseBetween(const TimedPose* before, const TimedPose* after,
                       mrpt::Clock::time_point time, const PoseLimits& limits);

/// From one time to another [s]; negative if `to` is the earlier one.
double secondsBetween(mrpt::Clock::time_point from, mrpt::Clock::time_point to);

/// Robot poses in the map frame, ordered by time.
class PoseTrack {
 public:
    using Time = mrpt::Clock::time_point;

    /// A later pose at the same time replaces the earlier one.
    void add(Time time, const mrpt::poses::CPose3D& T_map_robot);

    /// poseBetween() the neighbours of `time`.
    PoseAnswer lookUp(Time time, const PoseLimits& limits) const;

    /// The pose of lookUp(), if found.
    std::optional<mrpt::poses::CPose3D> at(Time time, const PoseLimits& limits = {}) const {
        return lookUp(time, limits).pose;
    }

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
