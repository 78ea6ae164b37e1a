// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/mrpt_compat.h>

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "sensors/sensor_returns.h"

namespace superray {
namespace {

/// [rad] 6.29 is a full circle, too; 270 are degrees.
constexpr double kWidest = 2 * M_PI + 0.01;

[[noreturn]] void failAngle(const mrpt::obs::CObservation& scan, const char* what, double value,
                            const char* rule) {
    std::ostringstream message;
    message << "scan \"" << scan.sensorLabel << "\": " << what << " = " << value
            << " rad: must be " << rule;
    throw std::invalid_argument(message.str());
}

}  // namespace

std::optional<SensorReturns> read(const mrpt::obs::CObservation2DRangeScan& scan,
                                  const ReturnOptions& options) {
    if (scan.getScanSize() == 0) return std::nullopt;
    if (!(scan.aperture >= 0 && scan.aperture <= kWidest))
        failAngle(scan, "aperture", double{scan.aperture}, "from 0 to 2 pi");
    SensorReturns out;
    out.sensorOnRobot = scan.sensorPose;
    out.planar = true;
    ReturnCollector to(out, options, scan.maxRange);
    // Not getScanAngle(): it divides by zero for a scan of one ray.
    const std::size_t n = scan.getScanSize();
    const double span = scan.rightToLeft ? scan.aperture : -scan.aperture;
    for (std::size_t i = 0; i < n; ++i) {
        if (!to.next()) continue;
        const double fraction =
            n > 1 ? static_cast<double>(i) / static_cast<double>(n - 1) : 0.5;
        to.measuredAt(fraction * options.sweepSeconds);
        const double angle = span * (fraction - 0.5);
        const Eigen::Vector3f direction(static_cast<float>(std::cos(angle)),
                                        static_cast<float>(std::sin(angle)), 0.0f);
        const float range = scan.getScanRange(i);
        if (!scan.getScanRangeValidity(i) || std::isinf(range)) {
            to.noReturn(direction);
        } else if (range <= 0) {
            // Many drivers' "no echo", flagged valid: nothing is known, not even free space.
            to.invalid();
        } else {
            to.hit(direction * range, range);
        }
    }
    return out;
}

namespace {

template <class Scan>
SensorReturns readOrganizedPoints(const Scan& scan, const ReturnOptions& options) {
    SensorReturns out;
    if constexpr (HasOrganizedPoints<Scan>::value) {
        out.sensorOnRobot = scan.sensorPose;
        ReturnCollector to(out, options, scan.maxRange);
        const auto& points = scan.organizedPoints;
        for (int r = 0; r < static_cast<int>(points.rows()); ++r)
            for (int c = 0; c < static_cast<int>(points.cols()); ++c) {
                if (!to.next()) continue;
                const auto& p = points(r, c);
                if (p.x == 0 && p.y == 0 && p.z == 0) {
                    to.invalid();
                } else {
                    const Eigen::Vector3f point(static_cast<float>(p.x),
                                                static_cast<float>(p.y),
                                                static_cast<float>(p.z));
                    to.hit(point, point.norm());
                }
            }
    }
    return out;
}

}  // namespace

std::optional<SensorReturns> read(const mrpt::obs::CObservationRotatingScan& scan,
                                  const ReturnOptions& options) {
    if (hasOrganizedPoints(scan)) {
        auto points = readOrganizedPoints(scan, options);
        if (!points.hits.empty() || !isOneRow(scan)) return points;
    }
    if (!isOneRow(scan)) return std::nullopt;
    if (!std::isfinite(scan.startAzimuth))
        failAngle(scan, "startAzimuth", scan.startAzimuth, "finite");
    if (!(std::abs(scan.azimuthSpan) <= kWidest))
        failAngle(scan, "azimuthSpan", scan.azimuthSpan, "from -2 pi to 2 pi");
    SensorReturns out;
    out.sensorOnRobot = scan.sensorPose;
    ReturnCollector to(out, options, scan.maxRange);
    out.planar = true;
    const int n = static_cast<int>(scan.rangeImage.cols());
    for (int i = 0; i < n; ++i) {
        if (!to.next()) continue;
        const double fraction = n > 1 ? i / static_cast<double>(n - 1) : 0.5;
        to.measuredAt(fraction * options.sweepSeconds);
        const double azimuth = scan.startAzimuth + scan.azimuthSpan * fraction;
        const Eigen::Vector3f direction(static_cast<float>(std::cos(azimuth)),
                                        static_cast<float>(std::sin(azimuth)), 0.0f);
        const double range = scan.rangeImage(0, i) * scan.rangeResolution;
        if (range == 0) {
            to.noReturn(direction);
        } else if (range < scan.minRange) {
            to.invalid();
        } else {
            to.hit(direction * static_cast<float>(range), static_cast<float>(range));
        }
    }
    return out;
}

}  // namespace superray
