// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file CSuperRayGridMap3D.h

#include <superray/maps/super_ray_map_base.h>

namespace superray {

/// Hashed block grid in 3D: the fastest.
/// In .ini files: superRayGridMap3D_count.
class CSuperRayGridMap3D : public CSuperRayMapBase<3> {
    DEFINE_SERIALIZABLE(CSuperRayGridMap3D, superray)

 public:
    /// \param resolution cell edge [m]
    explicit CSuperRayGridMap3D(double resolution = 0.10)
        : CSuperRayMapBase<3>(StorageType::blockGrid, resolution) {}

    MAP_DEFINITION_START(CSuperRayGridMap3D)
    TMapOptions options;
    MAP_DEFINITION_END(CSuperRayGridMap3D)
};

}  // namespace superray
