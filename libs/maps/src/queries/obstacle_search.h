// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file obstacle_search.h
/// Occupied cells for questions without a reach.

#include <mrpt/maps/CSimplePointsMap.h>
#include <superray/maps/map_queries.h>

#include <mutex>
#include <optional>

#include "queries/distance_field.h"

namespace superray {

/// The occupied cell whose centre is nearest to that of the point's cell, if its box
/// is within maxDistance [m] of the point (which may be infinite).
/// \pre the point is addressable
template <int Dim>
std::optional<NearestObstacle> findNearestObstacle(
    DistanceField<Dim>& field, const typename DistanceField<Dim>::Source& source,
    const Point<Dim>& point, double maxDistance);

/// Squared distance [m^2] from (x, y), seen from above, to the nearest centre of an
/// occupied cell; infinite if there is none.
template <int Dim>
double squaredDistanceFromAbove(DistanceField<Dim>& field,
                                const typename DistanceField<Dim>::Source& source, double x,
                                double y);

/// Centres of the occupied cells as a points map (2D: z = 0), made when asked for.
template <int Dim>
class ObstaclePoints {
 public:
    /// Valid until the map changes. Safe to call concurrently.
    const mrpt::maps::CSimplePointsMap* get(DistanceField<Dim>& field,
                                            const typename DistanceField<Dim>::Source& source);

 private:
    std::mutex mutex_;
    bool made_ = false;
    typename ChangeLog<Dim>::Stamp stamp_ = 0;
    float occupied_ = 0;
    mrpt::maps::CSimplePointsMap points_;
};

extern template class ObstaclePoints<2>;
extern template class ObstaclePoints<3>;

}  // namespace superray
