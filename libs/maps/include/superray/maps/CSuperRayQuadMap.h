// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file CSuperRayQuadMap.h

#include <superray/maps/super_ray_map_base.h>

namespace superray {

/// 2D map in a pruned quadtree.
/// In .ini files: superRayQuadMap_count.
class CSuperRayQuadMap : public CSuperRayMapBase<2> {
    DEFINE_SERIALIZABLE(CSuperRayQuadMap, superray)

 public:
    /// \param resolution cell edge [m]
    explicit CSuperRayQuadMap(double resolution = 0.10)
        : CSuperRayMapBase<2>(StorageType::tree, resolution) {}

    MAP_DEFINITION_START(CSuperRayQuadMap)
    TMapOptions options;
    MAP_DEFINITION_END(CSuperRayQuadMap)
};

}  // namespace superray
