#pragma once
/// \file map_export.h
/// Views of a map for other programs; see SuperRayMapInterface.

#include <mrpt/opengl/COctoMapVoxels.h>
#include <superray/maps/options.h>
#include <superray/storage/occupancy_map.h>

#include <memory>
#include <string>

namespace superray {

/// Voxel sets VOXEL_SET_OCCUPIED and VOXEL_SET_FREESPACE, as the options say.
template <int Dim>
std::shared_ptr<mrpt::opengl::COctoMapVoxels> makeVoxels(const OccupancyMap<Dim>& map,
                                                         const SensorModel& model,
                                                         const TRenderingOptions& options);

/// .bt or .ot
void writeOctomap(const OccupancyMap<3>& map, const SensorModel& model,
                  const std::string& path);

template <int Dim>
void writePly(const OccupancyMap<Dim>& map, const SensorModel& model, const std::string& path);

void writePicture(const OccupancyMap<2>& map, const SensorModel& model,
                  const std::string& path);

}  // namespace superray
