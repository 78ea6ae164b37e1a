// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/CSuperRayPointsMap.h>

#include <superray/storage/memory_limit_error.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include "mrpt/points_map_occupancy.h"

namespace superray {

template <int Dim>
CSuperRayPointsMap<Dim>::CSuperRayPointsMap(double resolution)
    : occupancy_(std::make_unique<Occupancy>(*this, resolution)) {}

template <int Dim>
CSuperRayPointsMap<Dim>::~CSuperRayPointsMap() = default;

template <int Dim>
CSuperRayPointsMap<Dim>::CSuperRayPointsMap(const CSuperRayPointsMap& other)
    : AssignablePointsMap(),
      occupancy_(std::make_unique<Occupancy>(*this, other.occupancy_->resolution())) {
    copyAll(other);
}

template <int Dim>
CSuperRayPointsMap<Dim>& CSuperRayPointsMap<Dim>::operator=(const CSuperRayPointsMap& other) {
    if (this != &other) copyAll(other);
    return *this;
}

template <int Dim>
void CSuperRayPointsMap<Dim>::assignFrom(const mrpt::maps::CPointsMap& other) {
    const auto* same = dynamic_cast<const CSuperRayPointsMap*>(&other);
    if (!same)
        throw std::invalid_argument("CSuperRayPointsMap" + std::to_string(Dim) +
                                    "D: cannot be copied from another class of points map, "
                                    "which has no occupancy");
    operator=(*same);
}

template <int Dim>
void CSuperRayPointsMap<Dim>::copyAll(const CSuperRayPointsMap& other) {
    decltype(blocks_) blocks;
    for (const auto& [key, points] : other.blocks_)
        blocks.emplace(key, std::make_unique<BlockPoints>(*points));
    auto sources = other.sources_;
    occupancy_->takeFrom(*other.occupancy_);
    copyPoints(other);
    sources_ = std::move(sources);
    blocks_ = std::move(blocks);
}

// --- the map ------------------------------------------------------------------

template <int Dim>
const typename CSuperRayPointsMap<Dim>::GridMap& CSuperRayPointsMap<Dim>::occupancy() const {
    return *occupancy_;
}

template <int Dim>
bool CSuperRayPointsMap<Dim>::isEmpty() const {
    return occupancy_->isEmpty();
}

template <int Dim>
void CSuperRayPointsMap<Dim>::setOptions(const TMapOptions& options) {
    occupancy_->setOptions(options);
    genericMapParams = occupancy_->genericMapParams;
    if (!options.creation.load_from.empty()) forgetPoints();
    // Another threshold, another set of occupied cells.
    remakeOnFailure([this] { followAllBlocks(); });
}

template <int Dim>
void CSuperRayPointsMap<Dim>::loadFromFile(const std::string& path) {
    occupancy_->loadFromFile(path);
    genericMapParams = occupancy_->genericMapParams;
    forgetPoints();
    remakeOnFailure([this] { followAllBlocks(); });
}

template <int Dim>
std::string CSuperRayPointsMap<Dim>::asString() const {
    return std::to_string(size()) + " occupied cells as points, of " + occupancy_->asString();
}

template <int Dim>
void CSuperRayPointsMap<Dim>::getVisualizationInto(mrpt_viz::CSetOfObjects& objects) const {
    if (genericMapParams.enableSaveAs3DObject) occupancy_->getVisualizationInto(objects);
}

template <int Dim>
void CSuperRayPointsMap<Dim>::saveMetricMapRepresentationToFile(
    const std::string& prefix) const {
    occupancy_->saveMetricMapRepresentationToFile(prefix);
}

template <int Dim>
double CSuperRayPointsMap<Dim>::internal_computeObservationLikelihood(
    const mrpt::obs::CObservation& observation, const mrpt::poses::CPose3D& robotPose) const {
    return occupancy_->computeObservationLikelihood(observation, robotPose);
}

template <int Dim>
bool CSuperRayPointsMap<Dim>::internal_canComputeObservationLikelihood(
    const mrpt::obs::CObservation& observation) const {
    return occupancy_->canComputeObservationLikelihood(observation);
}

template <int Dim>
void CSuperRayPointsMap<Dim>::internal_clear() {
    occupancy_->clear();
    forgetPoints();
}

template <int Dim>
bool CSuperRayPointsMap<Dim>::internal_insertObservation(
    const mrpt::obs::CObservation& observation,
    const std::optional<const mrpt::poses::CPose3D>& robotPose) {
    occupancy_->genericMapParams = genericMapParams;
    try {
        // Calls prepare() and follow().
        return occupancy_->insertObservation(observation, robotPose);
    } catch (...) {
        forgetLostBlocks();
        throw;
    }
}

// --- the points ---------------------------------------------------------------

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
        occupancy_->storage().forEachWritten(
            counts, occupancy_->sensorModel(), occupancy_->insertionOptions.policy,
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
    const std::size_t points = forEachNewPoint(written, [this](const Cell<Dim>& c) { pointAt(c); });
    const auto makeRoom = [points](auto& list) {
        if (list.capacity() - list.size() < points)
            list.reserve(std::max(2 * list.capacity(), list.size() + points));
    };
    makeRoom(sources_);
    makeRoom(m_x);
    makeRoom(m_y);
    makeRoom(m_z);
}

template <int Dim>
void CSuperRayPointsMap<Dim>::follow(const RayBundle<Dim>& rays,
                                     const std::vector<BlockKey<Dim>>& forgotten) {
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

/// Memory may run out anywhere in `change`: then there are points made anew from the
/// cells, or none (the next scan makes them).
template <int Dim>
template <class Change>
void CSuperRayPointsMap<Dim>::remakeOnFailure(const Change& change) {
    try {
        change();
    } catch (const MemoryLimitError&) {
        throw;  // nothing has changed
    } catch (...) {
        forgetPoints();
        try {
            followAllBlocks();
        } catch (const std::bad_alloc&) {
            forgetPoints();
        }
        throw;
    }
}

template <int Dim>
void CSuperRayPointsMap<Dim>::forgetPoints() {
    sources_.clear();
    blocks_.clear();
    CSimplePointsMap::internal_clear();
}

template class CSuperRayPointsMap<2>;
template class CSuperRayPointsMap<3>;

}  // namespace superray
