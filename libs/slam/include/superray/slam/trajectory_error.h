// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file trajectory_error.h
/// How far an estimated trajectory is from the true one, in the usual measures.

#include <superray/eval/trajectory.h>

#include <cstddef>
#include <string>
#include <vector>

namespace superray {

/// Mean and extremes of error norms.
struct ErrorSummary {
    double rmse = 0, mean = 0, median = 0, maximum = 0;
    std::size_t count = 0;
};

/// Relative error over segments of one length, as in the KITTI benchmark: from
/// each pose to the first one that is `length` farther along the true path.
struct SegmentError {
    double length = 0;         ///< [m]
    double translation = 0;    ///< mean error / length
    double rotation = 0;       ///< mean error / length [rad/m]
    std::size_t segments = 0;  ///< 0: the path is too short
};

struct TrajectoryErrorOptions {
    /// [m]; empty: KITTI's 100, 200, ..., 800 m where the path is at least 200 m
    /// long, else a tenth, a quarter and half of it.
    std::vector<double> segmentLengths;
    std::size_t relativeStep = 1;  ///< >= 1; poses between the two of an RPE pair
};

struct TrajectoryError {
    std::size_t poses = 0;      ///< estimates with a true pose at their time
    std::size_t unmatched = 0;  ///< estimates without
    /// Poses of the files that are not finite, and were left out.
    std::size_t badEstimates = 0, badTruths = 0;
    double pathLength = 0;  ///< of the true poses [m]
    /// ATE: distances of the positions [m] after the rigid motion (no scale) that
    /// makes the sum of their squares least (Umeyama).
    ErrorSummary absolute;
    /// The same for the rotations [rad], after the same motion.
    ErrorSummary absoluteRotation;
    /// RPE: error of the motion over relativeStep poses [m], [rad].
    ErrorSummary relative, relativeRotation;
    std::vector<SegmentError> segments;
    /// Of the last pose where the first ones are laid on each other [m], [rad].
    double endTranslation = 0, endRotation = 0;

    /// End point error / path; 0 for a path of length 0.
    double drift() const { return pathLength > 0 ? endTranslation / pathLength : 0; }
};

/// True poses are interpolated at the times of the estimates.
/// \throws InputError with fewer than 3 poses in common, or options out of range
TrajectoryError compareTrajectories(const Trajectory& estimate, const Trajectory& truth,
                                    const TrajectoryErrorOptions& options = {});

/// Tables for people.
std::string describe(const TrajectoryError& error);
/// One JSON object: metres, radians, ratios.
std::string describeAsJson(const TrajectoryError& error);

}  // namespace superray
