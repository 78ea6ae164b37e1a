// SPDX-License-Identifier: BSD-3-Clause
// The points of a points map, which follow its cells.

#include <superray/core/detail/grow.h>

#include <limits>
#include <utility>

#include "mrpt/points_map_occupancy.h"

namespace superray {

template <int Dim>
void CSuperRayPointsMap<Dim>::prepare(const UpdateBatch<Dim>& batch) {
    completePoints();
    const SensorModel model = occupancy_->sensorModel();
    const bool missesMayOccupy = model.afterFewestMisses() >= model.occupied();
    UpdateBatch<Dim> mayOccupy;
    toFollow_.clear();
    for (std::size_t b = 0; b < batch.blockCount(); ++b) {
        const BlockKey<Dim>& key = batch.key(b);
        const bool may = missesMayOccupy || batch.hits(b);
        if (may) mayOccupy.borrowBlock(key, batch.misses(b), batch.hits(b));
        if (may || blocks_.count(key) != 0) toFollow_.push_back(key);
    }
    makeRoomFor([&](const typename OccupancyMap<Dim>::BlockVisitor& visit) {
        occupancy_->storage().forEachWritten(mayOccupy, model,
                                             occupancy_->insertionOptions.policy, visit);
    });
}

template <int Dim>
void CSuperRayPointsMap<Dim>::prepare(const CellCountMap<Dim>& counts) {
    completePoints();
    toFollow_.clear();
    makeRoomFor([&](const typename OccupancyMap<Dim>::BlockVisitor& visit) {
        occupancy_->storage().forEachWritten(counts, occupancy_->sensorModel(),
                                             occupancy_->insertionOptions.policy,
                                             [&](const BlockView<Dim>& block) {
                                                 toFollow_.push_back(block.key);
                                                 visit(block);
                                             });
    });
}

/// Occupied cells without points: somebody else changed the points, or memory ran out.
template <int Dim>
void CSuperRayPointsMap<Dim>::completePoints() {
    if (size() != sources_.size()) forgetPoints();
    if (!sources_.empty()) return;
    try {
        followAllBlocks();
    } catch (...) {
        forgetPoints();
        throw;
    }
}

/// For the points of cells that become occupied.
template <int Dim>
void CSuperRayPointsMap<Dim>::makeRoomFor(
    const typename OccupancyMap<Dim>::WrittenBlocks& written) {
    const std::size_t points =
        forEachNewPoint(written, [this](const Cell<Dim>& c) { pointAt(c); });
    detail::growBy(sources_, points);
    for (auto* const axis : {&m_x, &m_y, &m_z}) detail::growBy(*axis, points);
}

template <int Dim>
void CSuperRayPointsMap<Dim>::follow(const RayBundle<Dim>& rays, const BlockKeys& forgotten) {
    for (const BlockKey<Dim>& key : forgotten) forgetBlock(key);
    for (const BlockKey<Dim>& key : toFollow_)
        occupancy_->storage().visitBlock(
            key, [this](const BlockView<Dim>& block) { followBlock(block); });
    averageEnds(rays);
    mark_as_modified();
}

template <int Dim>
void CSuperRayPointsMap<Dim>::followAllBlocks() {
    occupancy_->storage().forEachBlock(
        [&](const BlockView<Dim>& block) { followBlock(block); });
    mark_as_modified();
}

/// Gives every occupied cell of a block its point, and no other cell.
template <int Dim>
void CSuperRayPointsMap<Dim>::followBlock(const BlockView<Dim>& block) {
    const float occupied = occupancy_->sensorModel().occupied();
    const auto found = blocks_.find(block.key);
    // Null: no point in this block yet, so no cell is looked up twice either.
    const BlockPoints* points = found == blocks_.end() ? nullptr : found->second.get();
    for (int i = 0; i < kBlockCells<Dim>; ++i) {
        const bool wanted = block.known.test(i) && block.values[i] >= occupied;
        const std::uint32_t point = points ? (*points)[static_cast<std::size_t>(i)] : kNoPoint;
        if (wanted && point == kNoPoint) {
            const Cell<Dim> cell = cellInBlock<Dim>(block.key, i);
            const Point<Dim> center = occupancy_->storage().geometry().center(cell);
            addPoint({cell, 0}, {static_cast<float>(center[0]), static_cast<float>(center[1]),
                                 Dim == 3 ? static_cast<float>(center[Dim - 1]) : 0.0f});
        } else if (!wanted && point != kNoPoint) {
            removePoint(point);
        }
    }
}

/// After a failure: removes the points of blocks that the window has forgotten.
template <int Dim>
void CSuperRayPointsMap<Dim>::forgetLostBlocks() {
    for (auto block = blocks_.begin(); block != blocks_.end();) {
        const BlockKey<Dim> key = (block++)->first;
        if (!occupancy_->storage().visitBlock(key, [](const BlockView<Dim>&) {}))
            forgetBlock(key);
    }
}

/// Removes the points of a block without known cells.
template <int Dim>
void CSuperRayPointsMap<Dim>::forgetBlock(const BlockKey<Dim>& key) {
    const auto found = blocks_.find(key);
    if (found == blocks_.end()) return;
    const std::unique_ptr<BlockPoints>& points = found->second;
    for (const std::uint32_t& point : *points)
        if (point != kNoPoint) removePoint(point);
    blocks_.erase(found);
}

template <int Dim>
void CSuperRayPointsMap<Dim>::averageEnds(const RayBundle<Dim>& rays) {
    const auto& geometry = rays.geometry();
    BlockKey<Dim> lastKey{};
    const BlockPoints* last = nullptr;  // neighbouring rays end in the same block
    for (std::size_t r = 0; r < rays.size(); ++r) {
        if (rays.kind(r) != RayEnd::hit) continue;
        const Point<Dim>& end = rays.end(r);
        const Cell<Dim> cell = geometry.cellOf(end);
        const BlockKey<Dim> key = blockOf<Dim>(cell);
        if (!last || key != lastKey) {
            const auto found = blocks_.find(key);
            if (found == blocks_.end()) continue;
            last = found->second.get();
            lastKey = key;
        }
        const std::uint32_t i = (*last)[static_cast<std::size_t>(indexInBlock<Dim>(cell))];
        if (i == kNoPoint) continue;
        std::uint32_t& ends = sources_[i].ends;
        if (ends < std::numeric_limits<std::uint32_t>::max()) ++ends;
        const auto approach = [&](float& mean, double value) {
            mean = static_cast<float>(mean + (value - mean) / ends);
        };
        approach(m_x[i], end[0]);
        approach(m_y[i], end[1]);
        if constexpr (Dim == 3) approach(m_z[i], end[2]);
    }
}

template <int Dim>
std::uint32_t& CSuperRayPointsMap<Dim>::pointAt(const Cell<Dim>& cell) {
    const BlockKey<Dim> key = blockOf<Dim>(cell);
    auto found = blocks_.find(key);
    if (found == blocks_.end()) {
        auto points = std::make_unique<BlockPoints>();
        points->fill(kNoPoint);
        found = blocks_.emplace(key, std::move(points)).first;
    }
    return (*found->second)[static_cast<std::size_t>(indexInBlock<Dim>(cell))];
}

template <int Dim>
void CSuperRayPointsMap<Dim>::addPoint(const Source& source,
                                       const std::array<float, 3>& position) {
    pointAt(source.cell) = static_cast<std::uint32_t>(sources_.size());
    sources_.push_back(source);
    insertPointFast(position[0], position[1], position[2]);
}

template <int Dim>
void CSuperRayPointsMap<Dim>::removePoint(std::uint32_t index) {
    // The last one takes its place.
    pointAt(sources_[index].cell) = kNoPoint;
    if (index + 1 != sources_.size()) {
        sources_[index] = sources_.back();
        pointAt(sources_[index].cell) = index;
        setPointFast(index, m_x.back(), m_y.back(), m_z.back());
    }
    sources_.pop_back();
    resize(sources_.size());
}

template <int Dim>
void CSuperRayPointsMap<Dim>::forgetPoints() {
    sources_.clear();
    blocks_.clear();
    CSimplePointsMap::internal_clear();
}

#define SUPERRAY_INSTANTIATE(Dim)                                                           \
    template void CSuperRayPointsMap<Dim>::prepare(const UpdateBatch<Dim>&);                \
    template void CSuperRayPointsMap<Dim>::prepare(const CellCountMap<Dim>&);               \
    template void CSuperRayPointsMap<Dim>::follow(const RayBundle<Dim>&, const BlockKeys&); \
    template void CSuperRayPointsMap<Dim>::makeRoomFor(                                     \
        const OccupancyMap<Dim>::WrittenBlocks&);                                           \
    template void CSuperRayPointsMap<Dim>::completePoints();                                \
    template void CSuperRayPointsMap<Dim>::followBlock(const BlockView<Dim>&);              \
    template void CSuperRayPointsMap<Dim>::followAllBlocks();                               \
    template void CSuperRayPointsMap<Dim>::forgetBlock(const BlockKey<Dim>&);               \
    template void CSuperRayPointsMap<Dim>::forgetLostBlocks();                              \
    template void CSuperRayPointsMap<Dim>::averageEnds(const RayBundle<Dim>&);              \
    template std::uint32_t& CSuperRayPointsMap<Dim>::pointAt(const Cell<Dim>&);             \
    template void CSuperRayPointsMap<Dim>::addPoint(const Source&,                          \
                                                    const std::array<float, 3>&);           \
    template void CSuperRayPointsMap<Dim>::removePoint(std::uint32_t);                      \
    template void CSuperRayPointsMap<Dim>::forgetPoints();
SUPERRAY_INSTANTIATE(2)
SUPERRAY_INSTANTIATE(3)
#undef SUPERRAY_INSTANTIATE

}  // namespace superray
