// SPDX-License-Identifier: BSD-3-Clause
#include "queries/ray_cast.h"

#include <superray/core/traversal.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace superray {
namespace {

template <int Dim>
Eigen::Vector3d in3D(const Point<Dim>& p) {
    Eigen::Vector3d q = Eigen::Vector3d::Zero();
    q.head<Dim>() = p;
    return q;
}

/// Largest t <= range for which origin + t * direction is addressable.
template <int Dim>
double rangeToBorder(const CellGeometry<Dim>& geometry, const Point<Dim>& origin,
                     const Point<Dim>& direction, double range) {
    // Within the border by a part of a cell, so that rounding cannot leave it.
    const double border = (kCellLimit - 1e-3) * geometry.resolution();
    for (int a = 0; a < Dim; ++a) {
        if (direction[a] == 0) continue;
        const double limit = direction[a] > 0 ? border : -border;
        range = std::min(range, std::max(0.0, (limit - origin[a]) / direction[a]));
    }
    return range;
}

/// Distance along the ray at which it enters a cell's box.
template <int Dim>
double entryOf(const CellGeometry<Dim>& geometry, const Cell<Dim>& cell,
               const Point<Dim>& origin, const Point<Dim>& direction, double range) {
    const Point<Dim> low = geometry.lowerCorner(cell);
    double entry = 0;
    for (int a = 0; a < Dim; ++a) {
        if (direction[a] == 0) continue;
        const double face = direction[a] > 0 ? low[a] : low[a] + geometry.resolution();
        entry = std::max(entry, (face - origin[a]) / direction[a]);
    }
    return std::min(entry, range);
}

}  // namespace

template <int Dim>
RayCastResult castRay(const OccupancyMap<Dim>& map, float occupied, const Point<Dim>& origin,
                      const Point<Dim>& direction, double maxRange, UnknownCells unknown) {
    const auto& geometry = map.geometry();
    if (!geometry.contains(origin))
        throw std::invalid_argument("ray: the origin must be in the addressable range");
    if (!direction.allFinite() || direction.isZero(0))
        throw std::invalid_argument("ray: the direction must be finite and not zero");
    if (!(maxRange > 0)) throw std::invalid_argument("ray: the maximum range must be > 0");
    // The squares of its coordinates may be more, or less, than a double can hold.
    const Point<Dim> unit = (direction / direction.cwiseAbs().maxCoeff()).normalized();
    const double range = rangeToBorder(geometry, origin, unit, maxRange);
    const Point<Dim> end = origin + range * unit;

    Units<Dim> from, to;
    for (int a = 0; a < Dim; ++a) {
        from[static_cast<std::size_t>(a)] = toUnits(geometry.scaled(origin[a]));
        to[static_cast<std::size_t>(a)] = toUnits(geometry.scaled(end[a]));
    }
    const RayLine<Dim> line(from, to);
    RayCastResult result;
    std::optional<Cell<Dim>> met;
    const auto look = [&](const Cell<Dim>& cell) {
        if (met) return;
        const auto value = map.logOdds(cell);
        if (value && *value >= occupied)
            result.end = RayCastEnd::hit;
        else if (!value && unknown == UnknownCells::stop)
            result.end = RayCastEnd::unknown;
        else
            return;
        met = cell;
    };
    for (std::int32_t slice = 0; slice < line.slices() && !met; ++slice)
        forEachFreeCell(line, slice, slice + 1, look);
    look(line.endCell());

    const Cell<Dim> last = met.value_or(line.endCell());
    result.distance = met ? entryOf(geometry, last, origin, unit, range) : range;
    result.point = in3D<Dim>(origin + result.distance * unit);
    result.cellCenter = in3D<Dim>(geometry.center(last));
    return result;
}

template RayCastResult castRay(const OccupancyMap<2>&, float, const Point<2>&, const Point<2>&,
                               double, UnknownCells);
template RayCastResult castRay(const OccupancyMap<3>&, float, const Point<3>&, const Point<3>&,
                               double, UnknownCells);

}  // namespace superray
