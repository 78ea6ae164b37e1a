// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file plan_output.h
/// 2D maps for other programs: ROS's map_server and nav2, and MRPT's grid maps.

#include <superray/core/sensor_model.h>
#include <superray/storage/occupancy_map.h>

#include <string>

namespace superray {

/// Writes NAME.yaml for an image of the map, row 0 at the top: its resolution and where its
/// lower left corner is in the map.
/// \param image name of the image, as the file is to say it
/// \throws MapFileError
void writePlanYaml(const OccupancyMap<2>& map, const std::string& path,
                   const std::string& image);

/// Writes NAME.yaml and NAME.pgm (occupied 0, free 254, unknown 205), which map_server and
/// nav2 read.
/// \throws std::invalid_argument for more than 32768 pixels a side; MapFileError
void writePlan(const OccupancyMap<2>& map, const SensorModel& model, const std::string& path);

/// Writes a COccupancyGridMap2D with the probabilities of the cells; unknown ones have 0.5.
/// \throws likewise
void writeGridmap(const OccupancyMap<2>& map, const std::string& path);

}  // namespace superray
