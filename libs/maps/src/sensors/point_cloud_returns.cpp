// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/mrpt_compat.h>

#include <stdexcept>
#include <string>

#include "sensors/loaded_observation.h"
#include "sensors/sensor_returns.h"

namespace superray {
namespace {

/// Empty if they are not wanted, or the cloud does not tell them.
std::vector<float> readTimes(const mrpt::obs::CObservationPointCloud& scan,
                             const ReturnOptions& options) {
    if (options.times == ReturnTimes::ignore) return {};
    const mrpt::maps::CPointsMap& cloud = *scan.pointcloud;
    auto times = pointTimes(cloud);
    if (!times.empty() && times.size() != cloud.size())
        throw std::invalid_argument(
            "point cloud \"" + scan.sensorLabel + "\": " + std::to_string(times.size()) +
            " times for " + std::to_string(cloud.size()) + " points; must be as many, or none");
    return times;
}

}  // namespace

std::optional<SensorReturns> read(const mrpt::obs::CObservationPointCloud& scan,
                                  const ReturnOptions& options) {
    std::optional<LoadedObservation> loaded;
    if (scan.isExternallyStored())
        loaded.emplace(scan, [&] { return static_cast<bool>(scan.pointcloud); });
    if (!scan.pointcloud) return std::nullopt;
    SensorReturns out;
    out.sensorOnRobot = scan.sensorPose;
    ReturnCollector to(out, options, 0);
    const auto& cloud = *scan.pointcloud;
    out.hits.reserve(cloud.size() / options.decimation + 1);
    const std::vector<float> times = readTimes(scan, options);
    collectPoints(cloud.getPointsBufferRef_x(), cloud.getPointsBufferRef_y(),
                  cloud.getPointsBufferRef_z(), to,
                  [&](std::size_t i) { return times.empty() ? 0.0f : times[i]; });
    return out;
}

}  // namespace superray
