// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file sensor_points.h
/// Points of a scan, in the single precision that MRPT's clouds have.

#include <mrpt/maps/CSimplePointsMap.h>

#include <stdexcept>

namespace superray {

/// A coordinate of a country (UTM), not of a scan in the frame of its sensor: farther away than
/// single precision tells a millimetre, 32 km. Who knows the file adds its name.
class FarCoordinate : public std::range_error {
 public:
    using std::range_error::range_error;
};

/// Adds a point in the frame of the sensor [m]. One with a coordinate that is not finite, or
/// beyond the Earth, is skipped and counted where the scan is inserted.
/// \throws FarCoordinate
void addSensorPoint(mrpt::maps::CSimplePointsMap& points, double x, double y, double z);

}  // namespace superray
