// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file world_truth.h
/// Maps against the exact geometry of a simulated world.

#include <superray/core/block.h>
#include <superray/eval/bench_engine.h>
#include <superray/eval/simulated_world.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace superray {

/// A map is taken to say "occupied" from p = 0.5 on. A cell contains solid if the closed
/// cell shares a point with a solid; it is a seen surface if an exact ray ends in it.
struct TruthScore {
    std::uint64_t occupiedSolid = 0;   ///< cells said occupied that contain solid
    std::uint64_t occupiedFree = 0;    ///< cells said occupied that do not
    std::uint64_t missed = 0;          ///< seen surface cells not said occupied
    std::uint64_t knownFree = 0;       ///< cells without solid that the map knows
    std::uint64_t seenCells = 0;       ///< seen surface cells
    std::uint64_t seenPoints = 0;      ///< exact end points
    std::uint64_t seenPointsKept = 0;  ///< those whose cell is said occupied
    double iou() const;                ///< intersection over union of cells, in [0, 1]
    double completeness() const;       ///< share of the exact end points kept
    double cellCompleteness() const;   ///< share of the seen surface cells kept
    double freeSaidOccupied() const;   ///< share of knownFree
};

/// One cell as it is.
struct TrueCell {
    Cell<3> cell;
    bool solid;          ///< contains solid
    std::uint32_t seen;  ///< exact rays that end in it
};

/// What can be known from scans of a world that does not change. Every cell that a ray
/// crosses or ends in is judged, and no other.
class WorldTruth {
 public:
    /// \param resolution [m]
    /// \param inserted what maps are made of
    /// \param exact the same rays with their end on the surface
    WorldTruth(const SimulatedWorld& world, double resolution,
               const std::vector<PointScan>& inserted, const std::vector<PointScan>& exact);
    TruthScore score(const BenchEngine& engine) const;
    /// Visits the cells that are judged, in the order of the map's blocks.
    void forEachCell(const std::function<void(const TrueCell&)>& visit) const;
    const CellGeometry<3>& geometry() const { return geometry_; }

 private:
    struct Block {
        BlockKey<3> key;
        BlockMask<3> known, solid;
        std::vector<std::uint32_t> seen;  // of each cell; empty: none
    };
    CellGeometry<3> geometry_;
    std::vector<Block> blocks_;
};

}  // namespace superray
