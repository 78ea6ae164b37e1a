// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file neighbor_search.h

#include <superray/maps/nearest_neighbors.h>

#include "queries/distance_field.h"

namespace superray {

/// The points of the map that a query asks for, see NearestNeighbors.
///
/// Looks at the blocks around the point, nearest first, until none can have a nearer
/// point; at all of them where there are fewer, and for distances from above in 3D. May
/// be called concurrently.
template <int Dim>
std::vector<Neighbor> findNeighbors(DistanceField<Dim>& field,
                                    const typename DistanceField<Dim>::Source& source,
                                    const NeighborQuery& query);

}  // namespace superray
