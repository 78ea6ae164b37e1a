// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file range_slam.h
/// Trajectory and map from range scans without poses.

#include <mrpt/maps/CMetricMap.h>
#include <mrpt/maps/CSimpleMap.h>
#include <superray/eval/scan_source.h>
#include <superray/eval/trajectory.h>
#include <superray/slam/scan_registration.h>

#include <cstdint>
#include <functional>
#include <optional>

namespace superray {

/// What happened to one scan.
struct SlamStep {
    Registration registration;  ///< pose of the robot; the start pose for the first scan
    bool inserted = false;      ///< became part of the map
    double registrationSeconds = 0, insertionSeconds = 0;
};

/// Counts and times over a run.
struct SlamReport {
    std::uint64_t scans = 0;      ///< with a pose
    std::uint64_t keyFrames = 0;  ///< of those, inserted
    std::uint64_t weak = 0;       ///< of those, with too low a goodness to be inserted
    std::uint64_t unusable = 0;   ///< observations without ranges or points
    SkippedObservations skipped;  ///< left out by the input
    double goodnessSum = 0;
    double readSeconds = 0, registrationSeconds = 0, insertionSeconds = 0, totalSeconds = 0;
    std::string warning;
};

/// Simultaneous localisation and mapping: each scan is registered against the
/// map of the key frames before it. There is no loop closure.
class RangeSlam {
 public:
    /// \param map any of our 3D or 2D maps; gets the key frames
    /// \param T_map_start pose of the robot at the first scan
    /// \throws std::invalid_argument for invalid options
    RangeSlam(const TSlamOptions& options, mrpt::maps::CMetricMap::Ptr map,
              const mrpt::poses::CPose3D& T_map_start = {});

    /// The next scan. `scan.T_map_robot` is used only with MotionPrior::odometry,
    /// and of that only the change since the last scan.
    /// \return nothing if the observation has no ranges or points
    /// \throws std::exception if it cannot be read
    std::optional<SlamStep> process(const Scan& scan);

    /// Poses of the robot in the map frame, one per scan.
    const Trajectory& trajectory() const { return trajectory_; }
    /// Key frames: mean pose and the observation.
    const mrpt::maps::CSimpleMap& keyFrames() const { return keyFrames_; }
    const mrpt::maps::CMetricMap& map() const { return *map_; }

 private:
    /// Where the robot should be now, the best guess first.
    std::vector<mrpt::poses::CPose3D> starts(const Scan& scan) const;
    bool isKeyFrame(const Registration& registration) const;
    void insert(const Scan& scan, const SensorReturns& returns,
                const mrpt::poses::CPose3D& T_map_robot);

    TSlamOptions options_;
    ScanRegistration registration_;
    mrpt::maps::CMetricMap::Ptr map_;
    mrpt::maps::CSimpleMap keyFrames_;
    Trajectory trajectory_;
    mrpt::poses::CPose3D T_map_robot_, T_map_keyFrame_, T_odometry_robot_;
    /// Motion between the last two scans, and how long it took [s].
    mrpt::poses::CPose3D motion_;
    double motionSeconds_ = 0;
    Trajectory::Time lastTime_{};
};

/// Runs over a recording.
/// \param onStep called after every scan that was used
/// \throws InputError if the input breaks, or none of its scans could be used
SlamReport runSlam(ScanSource& source, RangeSlam& slam, const TSlamOptions& options,
                   const std::function<void(const SlamReport&, const SlamStep&)>& onStep);

}  // namespace superray
