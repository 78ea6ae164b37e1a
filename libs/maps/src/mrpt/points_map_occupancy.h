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

    void scanToCome(const UpdateBatch<Dim>& batch) override { points_.prepare(batch); }
    void scanToCome(const CellCountMap<Dim>& counts) override { points_.prepare(counts); }
    void scanApplied(const RayBundle<Dim>& rays, const BlockKeys& forgotten) override {
        points_.follow(rays, forgotten);
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

/// Calls visit(cell) for each cell without a point that is occupied when blocks are written.
/// \return how many
template <int Dim>
template <class Visit>
std::size_t CSuperRayPointsMap<Dim>::forEachNewPoint(
    const typename OccupancyMap<Dim>::WrittenBlocks& written, const Visit& visit) const {
    const float occupied = occupancy_->sensorModel().occupied();
    std::size_t count = 0;
    written([&](const BlockView<Dim>& block) {
        const auto found = blocks_.find(block.key);
        const BlockPoints* const points = found == blocks_.end() ? nullptr : &*found->second;
        for (int i = 0; i < kBlockCells<Dim>; ++i) {
            if (!block.known.test(i) || block.values[i] < occupied) continue;
            if (points && (*points)[static_cast<std::size_t>(i)] != kNoPoint) continue;
            visit(cellInBlock<Dim>(block.key, i));
            ++count;
        }
    });
    return count;
}

}  // namespace superray
