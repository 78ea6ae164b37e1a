// SPDX-License-Identifier: BSD-3-Clause
// Questions to a map, parts of it, and maps made of two.

#include <superray/maps/super_ray_map_base.h>
#include <superray/storage/map_file.h>
#include <superray/storage/memory_limit_error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "matching/likelihood.h"
#include "queries/coarse_levels.h"
#include "queries/map_algebra.h"
#include "queries/neighbor_search.h"
#include "queries/obstacle_search.h"
#include "queries/ray_cast.h"
#include "views/voxel_view.h"

namespace superray {

template <int Dim>
std::optional<double> CSuperRayMapBase<Dim>::occupancyAt(const Eigen::Vector3d& point) const {
    const Point<Dim> p = point.head<Dim>();
    if (!storage_->geometry().contains(p)) return std::nullopt;
    const auto value = storage_->logOdds(storage_->geometry().cellOf(p));
    if (!value) return std::nullopt;
    return probabilityOf(*value);
}

template <int Dim>
bool CSuperRayMapBase<Dim>::isOccupied(const Eigen::Vector3d& point) const {
    const Point<Dim> p = point.head<Dim>();
    if (!storage_->geometry().contains(p)) return false;
    const auto value = storage_->logOdds(storage_->geometry().cellOf(p));
    return value && *value >= sensorModel().occupied();
}

template <int Dim>
std::optional<NearestObstacle> CSuperRayMapBase<Dim>::nearestObstacle(
    const Eigen::Vector3d& point, double maxDistance) const {
    if (!(maxDistance >= 0))
        throw std::invalid_argument("nearest obstacle: the maximum distance must be >= 0");
    const Point<Dim> p = point.head<Dim>();
    return findNearestObstacle<Dim>(
        *distances_, {*storage_, changes_, sensorModel().occupied()}, p, maxDistance);
}

template <int Dim>
std::vector<Neighbor> CSuperRayMapBase<Dim>::neighbors(const NeighborQuery& query) const {
    return findNeighbors<Dim>(*distances_, {*storage_, changes_, sensorModel().occupied()},
                              query);
}

template <int Dim>
float CSuperRayMapBase<Dim>::squareDistanceToClosestCorrespondence(float x0, float y0) const {
    return static_cast<float>(squaredDistanceFromAbove<Dim>(
        *distances_, {*storage_, changes_, sensorModel().occupied()}, double{x0}, double{y0}));
}

template <int Dim>
const mrpt::maps::CSimplePointsMap* CSuperRayMapBase<Dim>::getAsSimplePointsMap() const {
    return obstaclePoints_->get(*distances_, {*storage_, changes_, sensorModel().occupied()});
}

template <int Dim>
RayCastResult CSuperRayMapBase<Dim>::castRay(const Eigen::Vector3d& origin,
                                             const Eigen::Vector3d& direction, double maxRange,
                                             UnknownCells unknown) const {
    return superray::castRay<Dim>(*storage_, sensorModel().occupied(), origin.head<Dim>(),
                                  direction.head<Dim>(), maxRange, unknown);
}

template <int Dim>
std::optional<float> CSuperRayMapBase<Dim>::logOddsAtLevel(const Eigen::Vector3d& point,
                                                           unsigned level,
                                                           LevelRule rule) const {
    const Point<Dim> p = point.head<Dim>();
    if (!storage_->geometry().contains(p)) return std::nullopt;
    return superray::logOddsAtLevel<Dim>(*storage_, storage_->geometry().cellOf(p), level,
                                         rule);
}

template <int Dim>
mrpt::maps::CMetricMap::Ptr CSuperRayMapBase<Dim>::subMap(const MetricBounds& box) const {
    auto cells = makeStorage<Dim>(type_, storage_->geometry());
    copyBox<Dim>(*storage_, box, *cells);
    // The copy of the map costs nothing: its cells are shared.
    auto copy = std::dynamic_pointer_cast<mrpt::maps::CMetricMap>(duplicateGetSmartPtr());
    auto& part = dynamic_cast<CSuperRayMapBase&>(*copy);
    part.storage_ = SharedStorage<Dim>(std::move(cells));
    part.last_ = part.totals_ = {};
    part.contentsChanged();
    return copy;
}

namespace {

template <int Dim>
typename OccupancyMap<Dim>::WrittenBlocks writing(const MergedBlocks<Dim>& blocks) {
    return [&blocks](const typename OccupancyMap<Dim>::BlockVisitor& visit) {
        for (const auto& block : blocks) visit({block.key, block.values.data(), block.known});
    };
}

/// A merge needs less than the machine's limit for itself, whatever the map holds already.
void requireMachineFor(std::size_t more, std::size_t held, const std::string& map) {
    const std::size_t limit = MapFileLimits::ofThisMachine().mapBytes;
    if (more > limit)
        throw MemoryLimitError(limit, held, held + more,
                               map + ": this merge would take " + std::to_string(more) +
                                   " bytes of memory or more, the limit is " +
                                   std::to_string(limit) +
                                   " (SUPERRAY_MAP_MEGABYTES); the map stays as it is. A "
                                   "coarser resolution needs less");
}

}  // namespace

template <int Dim>
void CSuperRayMapBase<Dim>::merge(const mrpt::maps::CMetricMap& other,
                                  const mrpt::poses::CPose3D& T_map_other) {
    const auto* from = dynamic_cast<const CSuperRayMapBase*>(&other);
    if (!from)
        throw std::invalid_argument(shortClassName() + ": cannot merge a " +
                                    other.GetRuntimeClass()->className + "; must be a " +
                                    std::to_string(Dim) + "D map of this library");
    const SensorModel model = sensorModel();
    const std::size_t held = heldBytes();
    // Far from both limits, as nearly always, the number of blocks tells that.
    const std::size_t bound = maxMegabytes_ == 0 ? std::numeric_limits<std::size_t>::max()
                                                 : std::size_t{maxMegabytes_} << 20;
    const std::size_t machine = MapFileLimits::ofThisMachine().mapBytes;
    const auto blocks = mergedBlocks<Dim>(
        *storage_, *from->storage_, T_map_other, model,
        [&](const MergedBlocks<Dim>& merged, std::size_t workingBytes) {
            const std::size_t most = storage_->heldBytesAtMost(merged.size(), 1) +
                                     surfaceBytes() + companionBytesAtMost(merged.size());
            if (most <= bound && most + workingBytes <= machine) return;
            const auto written = writing<Dim>(merged);
            requireRoomFor(written, surfaceBytes(), "this merge, or a part of it,");
            const std::size_t needed = storage_->heldBytesWith(written) + surfaceBytes() +
                                       companionBytesWith(written) + workingBytes;
            requireMachineFor(needed - std::min(needed, held), held, shortClassName());
        });
    if (blocks.empty()) return;
    const auto visitAll = writing<Dim>(blocks);
    changes_.begin();
    for (const auto& block : blocks) changes_.add(block.key);
    view_->forget();
    storage_.writable().setBlocks(visitAll);
}

#define SUPERRAY_INSTANTIATE(Dim)                                                              \
    template std::optional<double> CSuperRayMapBase<Dim>::occupancyAt(const Eigen::Vector3d&)  \
        const;                                                                                 \
    template bool CSuperRayMapBase<Dim>::isOccupied(const Eigen::Vector3d&) const;             \
    template std::optional<NearestObstacle> CSuperRayMapBase<Dim>::nearestObstacle(            \
        const Eigen::Vector3d&, double) const;                                                 \
    template std::vector<Neighbor> CSuperRayMapBase<Dim>::neighbors(const NeighborQuery&)      \
        const;                                                                                 \
    template float CSuperRayMapBase<Dim>::squareDistanceToClosestCorrespondence(float, float)  \
        const;                                                                                 \
    template const mrpt::maps::CSimplePointsMap* CSuperRayMapBase<Dim>::getAsSimplePointsMap() \
        const;                                                                                 \
    template RayCastResult CSuperRayMapBase<Dim>::castRay(                                     \
        const Eigen::Vector3d&, const Eigen::Vector3d&, double, UnknownCells) const;           \
    template std::optional<float> CSuperRayMapBase<Dim>::logOddsAtLevel(                       \
        const Eigen::Vector3d&, unsigned, LevelRule) const;                                    \
    template mrpt::maps::CMetricMap::Ptr CSuperRayMapBase<Dim>::subMap(const MetricBounds&)    \
        const;                                                                                 \
    template void CSuperRayMapBase<Dim>::merge(const mrpt::maps::CMetricMap&,                  \
                                               const mrpt::poses::CPose3D&);
SUPERRAY_INSTANTIATE(2)
SUPERRAY_INSTANTIATE(3)
#undef SUPERRAY_INSTANTIATE

}  // namespace superray
