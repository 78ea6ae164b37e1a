// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "sensors/camera_directions.h"
#include "sensors/loaded_observation.h"
#include "sensors/sensor_returns.h"

namespace superray {
namespace {

using mrpt::obs::CObservation3DRangeScan;

bool isExternallyStored(const CObservation3DRangeScan& scan) {
    return scan.rangeImage_isExternallyStored() || scan.points3D_isExternallyStored();
}

/// True if any of what is stored externally is in memory.
bool isLoaded(const CObservation3DRangeScan& scan) {
    return (scan.rangeImage_isExternallyStored() && scan.rangeImage.size() > 0) ||
           (scan.points3D_isExternallyStored() && !scan.points3D_x.empty());
}

void readRangeImage(const CObservation3DRangeScan& scan, SensorReturns& out,
                    ReturnCollector& to) {
    const auto& image = scan.rangeImage;
    const auto rows = static_cast<std::size_t>(image.rows());
    const auto columns = static_cast<std::size_t>(image.cols());
    const auto& camera = scan.cameraParams;
    if (rows != camera.nrows || columns != camera.ncols) {
        std::ostringstream message;
        message << "range image of " << columns << " x " << rows
                << " pixels: must have the size of its camera parameters, " << camera.ncols
                << " x " << camera.nrows;
        throw std::invalid_argument(message.str());
    }
    if (!(scan.rangeUnits > 0 && std::isfinite(scan.rangeUnits)))
        throw std::invalid_argument("rangeUnits = " + std::to_string(scan.rangeUnits) +
                                    ": must be finite and > 0");
    const auto directions =
        pixelDirections(camera, scan.range_is_depth ? RangeKind::depth : RangeKind::range);
    const std::size_t pixels = rows * columns;
    out.hits.reserve(pixels);
    const std::uint16_t* values = image.data();
    for (std::size_t i = 0; i < pixels; ++i) {
        if (!to.next()) continue;
        if (values[i] == 0) {
            to.noReturn((*directions)[i]);
        } else {
            const float metres = static_cast<float>(values[i]) * scan.rangeUnits;
            to.hit((*directions)[i] * metres, metres);
        }
    }
}

}  // namespace

std::optional<SensorReturns> read(const CObservation3DRangeScan& scan,
                                  const ReturnOptions& options) {
    std::optional<LoadedObservation> loaded;
    if (isExternallyStored(scan)) loaded.emplace(scan, [&] { return isLoaded(scan); });
    SensorReturns out;
    out.sensorOnRobot = scan.sensorPose;
    ReturnCollector to(out, options, scan.maxRange);
    if (scan.hasRangeImage && scan.rangeImage.size() > 0) {
        readRangeImage(scan, out, to);
    } else if (scan.hasPoints3D) {
        out.hits.reserve(scan.points3D_x.size());
        collectPoints(scan.points3D_x, scan.points3D_y, scan.points3D_z, to);
    } else {
        return std::nullopt;
    }
    return out;
}

}  // namespace superray
