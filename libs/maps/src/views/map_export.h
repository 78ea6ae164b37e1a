// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_export.h
/// Views of a map for other programs; see SuperRayMapInterface and CSuperRayMapBase.

#include <superray/core/sensor_model.h>
#include <superray/storage/occupancy_map.h>

#include <string>

namespace superray {

/// .bt or .ot
void writeOctomap(const OccupancyMap<3>& map, const SensorModel& model,
                  const std::string& path);

template <int Dim>
void writePly(const OccupancyMap<Dim>& map, const SensorModel& model, const std::string& path);

void writePicture(const OccupancyMap<2>& map, const SensorModel& model,
                  const std::string& path);

}  // namespace superray
