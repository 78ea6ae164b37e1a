// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The grid map in a points map.

#include <superray/maps/CSuperRayPointsMap.h>

namespace superray {

/// The grid map, which reports each scan to the points.
template <int Dim>
class CSuperRayPointsMap<Dim>::Occupancy final : public GridMap {
 public:
    Occupancy(CSuperRayPointsMap& points, double resolution)
        : GridMap(resolution), points_(points) {}
    void takeFrom(const GridMap& other) { GridMap::operator=(other); }
    /// \throws MemoryLimitError if cells and points are beyond the bound
    void requireBound() const {
        this->requireWithin(this->options().creation.max_memory_megabytes, this->heldBytes(),
                            "the map to be loaded");
    }

 private:
    using typename GridMap::BlockKeys;
    using typename GridMap::WrittenBlocks;

    void scanApplied(const RayBundle<Dim>& rays, const UpdateBatch<Dim>* batch,
                     const BlockKeys& forgotten) override {
        points_.follow(rays, batch, forgotten);
    }
    std::size_t companionBytes() const override { return points_.pointBytes(); }
    std::size_t companionBytesAtMost(std::size_t blocks) const override {
        return points_.pointBytesAtMost(blocks * kBlockCells<Dim>, blocks);
    }
    std::size_t companionBytesWith(const WrittenBlocks& written) const override {
        return points_.pointBytesWith(written);
    }
    std::size_t companionBytesOf(const OccupancyMap<Dim>& cells,
                                 float occupied) const override {
        return points_.pointBytesOf(cells, occupied);
    }
    CSuperRayPointsMap& points_;
};

}  // namespace superray
