// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_queries.h
/// What maps are asked and what they answer; see SuperRayMapInterface. Points are
/// in the map frame [m]; 2D maps ignore z, and set it to 0.

#include <Eigen/Core>
#include <cstdint>

namespace superray {

/// Numbers of cells.
struct CellTotals {
    std::uint64_t known = 0, occupied = 0, free = 0;
};

/// Axis-aligned box [m, map frame]; z is 0 in 2D.
struct MetricBounds {
    Eigen::Vector3d lowest, highest;
};

/// The occupied cell nearest to a point.
struct NearestObstacle {
    Eigen::Vector3d cellCenter;  ///< [m]
    double distance = 0;         ///< from the point to the cell's box [m], 0 inside
};

/// What unknown cells do to a ray.
enum class UnknownCells : std::uint8_t { pass, stop };

/// What a ray met first.
enum class RayCastEnd : std::uint8_t {
    hit,      ///< an occupied cell
    unknown,  ///< an unknown cell (with UnknownCells::stop)
    nothing   ///< neither within the range, or before the border of the addressable cells
};

struct RayCastResult {
    RayCastEnd end = RayCastEnd::nothing;
    Eigen::Vector3d cellCenter;  ///< of the cell it met; without one, of the last cell
    Eigen::Vector3d point;       ///< where it enters that cell; without one, its end
    double distance = 0;         ///< from the origin to `point` [m]
};

/// How the cells of a coarser cell are summed up; both as OctoMap's inner nodes.
enum class LevelRule : std::uint8_t {
    maximum,  ///< of the known cells (what OctoMap keeps)
    mean      ///< mean probability of the known halves, of their known halves, ...
};

}  // namespace superray
