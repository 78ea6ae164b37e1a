// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file ray_cast.h

#include <superray/maps/map_queries.h>
#include <superray/storage/occupancy_map.h>

namespace superray {

/// Walks from `origin` along `direction` over the cells of the digital line that
/// an inserted ray between the same points has; the cell of the origin counts.
/// \param occupied log-odds from which a cell is occupied
/// \param maxRange [m], > 0; may be infinite
/// \throws std::invalid_argument if the origin is not addressable, the direction is
/// zero or not finite, or the range is not > 0
template <int Dim>
RayCastResult castRay(const OccupancyMap<Dim>& map, float occupied, const Point<Dim>& origin,
                      const Point<Dim>& direction, double maxRange, UnknownCells unknown);

}  // namespace superray
