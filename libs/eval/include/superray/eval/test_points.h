// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file test_points.h
/// Points held out of scans, of which the truth is taken as known (Sec. V-B of the paper).

#include <superray/eval/point_scan.h>

#include <cstdint>
#include <vector>

namespace superray {

/// Which points the maps are built from. Test points are the same in both.
enum class TrainingPoints : std::uint8_t {
    share,  ///< those that are not test points
    all     ///< whole scans: the time that a robot would need
};

struct SplitOptions {
    double resolution = 0.2;  ///< [m]
    TrainingPoints training = TrainingPoints::share;
    double testShare = 0.2;  ///< in (0, 1): of the points of each scan
    std::uint64_t seed = 1;  ///< of the choice of test points
    /// \throws InputError, std::invalid_argument
    void validate() const;
};

/// A point of which the truth is taken as known.
struct TestPoint {
    Eigen::Vector3f point;  ///< [m, map frame]
    bool occupied;
    std::uint32_t scan, ray;  ///< whose end it is, or on which it lies
};

/// Scans parted for training and testing.
struct TrainTestSplit {
    std::vector<PointScan> training;  ///< as many as there are scans
    std::vector<TestPoint> tests;     ///< of all scans
};
/// The end points of test rays are occupied; on each test ray one free point is
/// drawn, evenly, at least two cells before the end (none on shorter rays).
TrainTestSplit splitScans(const std::vector<PointScan>& scans, const SplitOptions& options);

}  // namespace superray
