#include "sensors/loaded_observation.h"
#include "sensors/sensor_returns.h"

namespace superray {

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
    collectPoints(cloud.getPointsBufferRef_x(), cloud.getPointsBufferRef_y(),
                  cloud.getPointsBufferRef_z(), to);
    return out;
}

}  // namespace superray
