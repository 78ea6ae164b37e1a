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

 private:
    void scanApplied(const RayBundle<Dim>& rays, const UpdateBatch<Dim>* batch) override {
        points_.follow(rays, batch);
    }
    CSuperRayPointsMap& points_;
};

}  // namespace superray
