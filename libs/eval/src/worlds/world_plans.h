// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file world_plans.h
/// What the simulated worlds hold, one file each.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "worlds/solid_scene.h"

namespace superray {

/// A sensor with columns of beams, turning about its upright axis.
struct SpinningSensor {
    int columns;                      ///< per turn
    int beams;                        ///< per column
    double lowestBeam, highestBeam;   ///< elevation, in turns (1/4: straight up)
    double range;                     ///< [m]
    double noise;                     ///< sigma of the range [m]
    Eigen::Vector3d positionOnRobot;  ///< [m]; robot on the ground, x forward
    double yawOnRobot;                ///< in turns
    double secondsPerScan;
};

/// What does not stay where it is, beside the fixed scene.
struct MovingThings {
    Cylinder walker;          ///< where it is in the first scan
    Eigen::Vector2d step;     ///< of the walker, a scan [m]
    Box removed;              ///< a thing that somebody takes away
    std::size_t removalScan;  ///< first scan without it
    Cylinder walkerAt(std::size_t scan) const;
};

struct WorldPlan {
    SolidScene scene;  ///< what is fixed
    std::optional<MovingThings> moving;
    SpinningSensor sensor;
    /// The robot drives along these lines, scans evenly spaced [m].
    std::vector<Eigen::Vector2d> path;
    std::size_t scans, pointsPerScan;
};

WorldPlan planIndoor(std::uint64_t seed);
WorldPlan planOutdoor(std::uint64_t seed);
WorldPlan planWalker(std::uint64_t seed);

}  // namespace superray
