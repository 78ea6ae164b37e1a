// SPDX-License-Identifier: BSD-3-Clause
#include "sources/clouds/sensor_points.h"

#include <cmath>
#include <limits>
#include <sstream>

namespace superray {
namespace {

/// Farther away, single precision does not tell a millimetre [m].
constexpr double kFarthest = 32768;
/// Nothing on Earth is farther away: a value that tells that there is no point [m].
constexpr double kNowhere = 4.1e7;

float singlePrecision(double value, char axis) {
    const double distance = std::abs(value);
    if (distance > kFarthest && distance < kNowhere) {
        std::ostringstream text;
        text.precision(12);
        text << "has points at " << axis << ' ' << value
             << " m: coordinates of a country, not of a scan in the frame of its sensor";
        throw FarCoordinate(text.str());
    }
    const bool fits = distance <= double{std::numeric_limits<float>::max()};
    return fits ? static_cast<float>(value) : std::numeric_limits<float>::quiet_NaN();
}

}  // namespace

void addSensorPoint(mrpt::maps::CSimplePointsMap& points, double x, double y, double z) {
    points.insertPointFast(singlePrecision(x, 'x'), singlePrecision(y, 'y'),
                           singlePrecision(z, 'z'));
}

}  // namespace superray
