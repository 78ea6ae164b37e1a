// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_picture.h
/// A picture of a map, drawn without a display or a graphics driver.

#include <mrpt/img/CImage.h>
#include <superray/core/sensor_model.h>
#include <superray/storage/occupancy_map.h>

#include <limits>

namespace superray {

struct PictureOptions {
    int width = 1600, height = 900;  ///< [pixels], each in [200, 10000]
    /// [m] cells above this height are left out: looks into a room from above.
    double cutAbove = std::numeric_limits<double>::infinity();
};

/// The occupied cells as shaded cubes coloured by height, seen obliquely and,
/// beside it, from above; with scale bars. Stray cells far from all others may
/// lie outside the picture.
/// \throws std::invalid_argument if there is nothing to draw, or for bad options
mrpt::img::CImage drawMap(const OccupancyMap<3>& map, const SensorModel& model,
                          const PictureOptions& options = {});

}  // namespace superray
