// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file occupancy_of.h
/// The cells of any map class.

#include <superray/maps/CSuperRayPointsMap.h>
#include <superray/maps/super_ray_map_base.h>

namespace superray::test {

/// The grid or octree map that a map is or holds.
template <int Dim>
const CSuperRayMapBase<Dim>& occupancyOf(const CSuperRayMapBase<Dim>& map) {
    return map;
}
template <int Dim>
const CSuperRayMapBase<Dim>& occupancyOf(const CSuperRayPointsMap<Dim>& map) {
    return map.occupancy();
}

}  // namespace superray::test
