// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file CSuperRayOctoMap.h

#include <superray/maps/super_ray_map_base.h>

namespace octomap {
class OcTree;
}

namespace superray {

/// 3D map in an octomap::OcTree.
/// In .ini files: superRayOctoMap_count.
class CSuperRayOctoMap : public CSuperRayMapBase<3> {
    DEFINE_SERIALIZABLE(CSuperRayOctoMap, superray)

 public:
    /// \param resolution cell edge [m]
    explicit CSuperRayOctoMap(double resolution = 0.10)
        : CSuperRayMapBase<3>(StorageType::tree, resolution) {}

    /// The tree: pruned, inner nodes up to date. Valid until the map is loaded,
    /// assigned to, given another resolution, or changed after it was copied.
    const octomap::OcTree& octree() const;

    MAP_DEFINITION_START(CSuperRayOctoMap)
    TMapOptions options;
    MAP_DEFINITION_END(CSuperRayOctoMap)
};

}  // namespace superray
