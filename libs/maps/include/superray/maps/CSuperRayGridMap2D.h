// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file CSuperRayGridMap2D.h

#include <superray/maps/super_ray_map_base.h>

namespace superray {

/// Hashed block grid in 2D.
/// In .ini files: superRayGridMap2D_count.
class CSuperRayGridMap2D : public CSuperRayMapBase<2> {
    DEFINE_SERIALIZABLE(CSuperRayGridMap2D, superray)

 public:
    /// \param resolution cell edge [m]
    explicit CSuperRayGridMap2D(double resolution = 0.10)
        : CSuperRayMapBase<2>(StorageType::blockGrid, resolution) {}

    MAP_DEFINITION_START(CSuperRayGridMap2D)
    TMapOptions options;
    MAP_DEFINITION_END(CSuperRayGridMap2D)
};

}  // namespace superray
