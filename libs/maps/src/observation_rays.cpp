#include <superray/maps/mrpt_compat.h>
#include <superray/maps/observation_rays.h>

#include "sensor_returns.h"

namespace superray {
namespace {

/// Calls f with the observation as what it is; a default result for others.
template <class F>
auto visitObservation(const mrpt::obs::CObservation& o, F f)
    -> decltype(f(std::declval<const mrpt::obs::CObservation2DRangeScan&>())) {
    using namespace mrpt::obs;
    if (const auto* scan = dynamic_cast<const CObservation3DRangeScan*>(&o)) return f(*scan);
    if (const auto* scan = dynamic_cast<const CObservationVelodyneScan*>(&o)) return f(*scan);
    if (const auto* scan = dynamic_cast<const CObservationPointCloud*>(&o)) return f(*scan);
    if (const auto* scan = dynamic_cast<const CObservation2DRangeScan*>(&o)) return f(*scan);
    if (const auto* scan = dynamic_cast<const CObservationRotatingScan*>(&o)) return f(*scan);
    return {};
}

bool hasData(const mrpt::obs::CObservation3DRangeScan& o) {
    return o.hasRangeImage || o.hasPoints3D;
}
bool hasData(const mrpt::obs::CObservationVelodyneScan& o) {
    return !o.scan_packets.empty() || o.point_cloud.size() > 0;
}
bool hasData(const mrpt::obs::CObservationPointCloud& o) {
    return o.pointcloud || o.isExternallyStored();
}
bool hasData(const mrpt::obs::CObservation2DRangeScan& o) {
    return o.getScanSize() > 0;
}
bool hasData(const mrpt::obs::CObservationRotatingScan& o) {
    return HasOrganizedPoints<mrpt::obs::CObservationRotatingScan>::value || o.rowCount == 1;
}

}  // namespace

bool canReadReturns(const mrpt::obs::CObservation& observation) {
    return visitObservation(observation, [](const auto& scan) { return hasData(scan); });
}

std::optional<SensorReturns> readReturns(const mrpt::obs::CObservation& observation,
                                         const ReturnOptions& options) {
    return visitObservation(observation, [&](const auto& scan) { return read(scan, options); });
}

template <int Dim>
RayBundle<Dim> toRays(const SensorReturns& returns, const mrpt::poses::CPose3D& T_map_robot,
                      const CellGeometry<Dim>& geometry, const TInsertionOptions& options,
                      TInsertionReport& report) {
    const mrpt::poses::CPose3D T_map_sensor = T_map_robot + returns.sensorOnRobot;
    const auto& rotation = T_map_sensor.getRotationMatrix();
    Eigen::Matrix3d R;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) R(r, c) = rotation(r, c);
    const Eigen::Vector3d t(T_map_sensor.x(), T_map_sensor.y(), T_map_sensor.z());

    RayBundle<Dim> rays(geometry, t.template head<Dim>(), options.rangeLimits());
    rays.reserve(returns.hits.size() + returns.noReturns.size());
    const auto add = [&](const std::vector<Eigen::Vector3f>& points, RayEnd kind) {
        for (const auto& p_sensor : points) {
            const Eigen::Vector3d p_map = R * p_sensor.cast<double>() + t;
            // NaN passes both tests; the bundle skips and counts it.
            if (!returns.planar &&
                (p_map.z() < options.heightBandMin || p_map.z() > options.heightBandMax)) {
                ++report.outOfHeightBand;
                continue;
            }
            rays.add(p_map.template head<Dim>(), kind);
        }
    };
    add(returns.hits, RayEnd::hit);
    add(returns.noReturns, RayEnd::open);
    report.skipped += rays.skipped();
    report.noReturns += returns.noReturnCount;
    return rays;
}

template RayBundle<2> toRays(const SensorReturns&, const mrpt::poses::CPose3D&,
                             const CellGeometry<2>&, const TInsertionOptions&,
                             TInsertionReport&);
template RayBundle<3> toRays(const SensorReturns&, const mrpt::poses::CPose3D&,
                             const CellGeometry<3>&, const TInsertionOptions&,
                             TInsertionReport&);

}  // namespace superray
