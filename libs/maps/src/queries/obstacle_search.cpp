// SPDX-License-Identifier: BSD-3-Clause
#include "queries/obstacle_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "queries/distance_to_cell.h"

namespace superray {
namespace {

/// Squared distance from a point to a box, over the first `axes` axes.
template <int Dim>
double squaredGap(const Point<Dim>& p, const Point<Dim>& low, double edge, int axes) {
    double sum = 0;
    for (int a = 0; a < axes; ++a) {
        const double gap = std::max({0.0, low[a] - p[a], p[a] - low[a] - edge});
        sum += gap * gap;
    }
    return sum;
}

/// The occupied cell whose centre is nearest to p over the first `axes` axes. Blocks
/// that cannot have a nearer one are passed over.
template <int Dim>
std::optional<Cell<Dim>> nearestCenter(DistanceField<Dim>& field,
                                       const typename DistanceField<Dim>::Source& source,
                                       const Point<Dim>& p, int axes, double& squared) {
    const auto& geometry = source.map.geometry();
    const double blockEdge = kBlockEdge * geometry.resolution();
    std::optional<Cell<Dim>> best;
    squared = std::numeric_limits<double>::infinity();
    field.forEachOccupiedBlock(
        source, [&](const BlockKey<Dim>& key, const BlockMask<Dim>& mask) {
            const Point<Dim> corner = geometry.lowerCorner(cellInBlock<Dim>(key, 0));
            if (squaredGap<Dim>(p, corner, blockEdge, axes) >= squared) return;
            for (int i = 0; i < kBlockCells<Dim>; ++i) {
                if (!mask.test(i)) continue;
                const Cell<Dim> cell = cellInBlock<Dim>(key, i);
                const double s = squaredGap<Dim>(p, geometry.center(cell), 0, axes);
                if (s >= squared) continue;
                squared = s;
                best = cell;
            }
        });
    return best;
}

}  // namespace

template <int Dim>
std::optional<NearestObstacle> findNearestObstacle(
    DistanceField<Dim>& field, const typename DistanceField<Dim>::Source& source,
    const Point<Dim>& point, double maxDistance) {
    using Field = DistanceField<Dim>;
    const auto& geometry = source.map.geometry();
    constexpr double kFarthest = 1e150;  // [m], its square is finite
    if (!point.allFinite() || point.cwiseAbs().maxCoeff() > kFarthest) return std::nullopt;
    const bool hasCell = geometry.contains(point);
    Cell<Dim> own{};
    std::optional<Cell<Dim>> cell;
    double squared = 0;
    if (hasCell) {
        own = geometry.cellOf(point);
        const double reach = Field::reachFor(maxDistance, geometry.resolution());
        typename Field::Code code;
        field.nearest(source, reach, &own, 1, &code);
        if (code.found()) {
            cell = code.offset();
            for (std::size_t a = 0; a < Dim; ++a) (*cell)[a] += own[a];
        } else if (reach == Field::kMaxReach) {
            cell = nearestCenter<Dim>(field, source, geometry.center(own), Dim, squared);
        }
    } else {
        cell = nearestCenter<Dim>(field, source, point, Dim, squared);
    }
    if (!cell) return std::nullopt;
    NearestObstacle found;
    found.distance = hasCell && *cell == own ? 0 : distanceToCell<Dim>(point, *cell, geometry);
    if (found.distance > maxDistance) return std::nullopt;
    found.cellCenter.setZero();
    found.cellCenter.template head<Dim>() = geometry.center(*cell);
    return found;
}

template <int Dim>
double squaredDistanceFromAbove(DistanceField<Dim>& field,
                                const typename DistanceField<Dim>::Source& source, double x,
                                double y) {
    // Comparisons would take NaN for a distance of 0.
    if (!std::isfinite(x) || !std::isfinite(y)) return std::numeric_limits<double>::infinity();
    Point<Dim> p = Point<Dim>::Zero();
    p[0] = x;
    p[1] = y;
    double squared = 0;
    nearestCenter<Dim>(field, source, p, 2, squared);
    return squared;
}

template <int Dim>
const mrpt::maps::CSimplePointsMap* ObstaclePoints<Dim>::get(
    DistanceField<Dim>& field, const typename DistanceField<Dim>::Source& source) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto now = source.changes.stamp();
    if (made_ && stamp_ == now && occupied_ == source.occupied) return &points_;
    points_.clear();
    field.forEachOccupiedBlock(
        source, [&](const BlockKey<Dim>& key, const BlockMask<Dim>& mask) {
            for (int i = 0; i < kBlockCells<Dim>; ++i) {
                if (!mask.test(i)) continue;
                const Point<Dim> p = source.map.geometry().center(cellInBlock<Dim>(key, i));
                points_.insertPointFast(static_cast<float>(p[0]), static_cast<float>(p[1]),
                                        Dim == 3 ? static_cast<float>(p[Dim - 1]) : 0.0f);
            }
        });
    points_.mark_as_modified();
    made_ = true;
    stamp_ = now;
    occupied_ = source.occupied;
    return &points_;
}

#define SUPERRAY_INSTANTIATE(Dim)                                                           \
    template std::optional<NearestObstacle> findNearestObstacle<Dim>(                       \
        DistanceField<Dim>&, const DistanceField<Dim>::Source&, const Point<Dim>&, double); \
    template double squaredDistanceFromAbove<Dim>(                                          \
        DistanceField<Dim>&, const DistanceField<Dim>::Source&, double, double);            \
    template class ObstaclePoints<Dim>;
SUPERRAY_INSTANTIATE(2)
SUPERRAY_INSTANTIATE(3)
#undef SUPERRAY_INSTANTIATE

}  // namespace superray
