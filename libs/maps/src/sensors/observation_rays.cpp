// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/mrpt_compat.h>
#include <superray/maps/observation_rays.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "sensors/ray_cutter.h"
#include "sensors/sensor_returns.h"

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
    // In this order: another thread may be loading an external cloud.
    return o.isExternallyStored() || o.pointcloud;
}
bool hasData(const mrpt::obs::CObservation2DRangeScan& o) {
    return o.getScanSize() > 0;
}
bool hasData(const mrpt::obs::CObservationRotatingScan& o) {
    return hasOrganizedPoints(o) || isOneRow(o);
}

}  // namespace

bool canReadReturns(const mrpt::obs::CObservation& observation) {
    return visitObservation(observation, [](const auto& scan) { return hasData(scan); });
}

std::string whyUnreadable(const mrpt::obs::CObservation& observation) {
    const auto* scan = dynamic_cast<const mrpt::obs::CObservationRotatingScan*>(&observation);
    if (scan == nullptr || scan->rangeImage.rows() < 2 || hasOrganizedPoints(*scan)) return {};
    return "the rotating scan '" + scan->sensorLabel + "' has " +
           std::to_string(scan->rangeImage.rows()) +
           " rows of ranges and no points, and MRPT keeps no vertical angles of the rows: "
           "record its packets (CObservationVelodyneScan) or points (CObservationPointCloud)";
}

std::optional<SensorReturns> readReturns(const mrpt::obs::CObservation& observation,
                                         const ReturnOptions& options) {
    return visitObservation(observation, [&](const auto& scan) { return read(scan, options); });
}

namespace {

/// Sensor points to the map frame.
struct Transform {
    Eigen::Matrix3d R;
    Eigen::Vector3d t;

    explicit Transform(const mrpt::poses::CPose3D& T_map_sensor)
        : t(T_map_sensor.x(), T_map_sensor.y(), T_map_sensor.z()) {
        const auto& rotation = T_map_sensor.getRotationMatrix();
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) R(r, c) = rotation(r, c);
    }
    Eigen::Vector3d operator()(const Eigen::Vector3f& p_sensor) const {
        return R * p_sensor.cast<double>() + t;
    }
};

/// False if a pose has NaN or Inf: then it is none.
bool isFinite(const mrpt::poses::CPose3D& pose) {
    const Transform T(pose);
    return T.R.allFinite() && T.t.allFinite();
}

/// The transform of a time, made anew only when the time changes.
class MovingSensor {
 public:
    MovingSensor(const SensorReturns& returns, mrpt::Clock::time_point timestamp,
                 const PoseAtTime& T_map_robot)
        : returns_(returns), timestamp_(timestamp), T_map_robot_(T_map_robot) {}

    /// nullptr if there is no pose, as for a time that is none
    const Transform* at(float seconds) {
        // NaN, and what the clock could not count to.
        if (!(std::abs(seconds) < kFarthest)) return nullptr;
        if (!known_ || seconds != seconds_) {
            known_ = true;
            seconds_ = seconds;
            const auto after = std::chrono::duration<double>(double{seconds});
            const auto pose = T_map_robot_(
                timestamp_ + std::chrono::duration_cast<mrpt::Clock::duration>(after));
            transform_.reset();
            if (pose && isFinite(*pose)) transform_.emplace(*pose + returns_.sensorOnRobot);
        }
        return transform_ ? &*transform_ : nullptr;
    }

 private:
    static constexpr float kFarthest = 1e9f;  // [s], 30 years
    const SensorReturns& returns_;
    mrpt::Clock::time_point timestamp_;
    const PoseAtTime& T_map_robot_;
    bool known_ = false;
    float seconds_ = 0;
    std::optional<Transform> transform_;
};

/// True if a planar scanner looks too far up or down for a 2D map.
template <int Dim>
bool isTilted(const SensorReturns& returns, const Transform& T_map_sensor,
              const TInsertionOptions& options) {
    if (Dim != 2 || !returns.planar) return false;
    // Upside down is level too.
    const double cosine = std::min(std::abs(T_map_sensor.R(2, 2)), 1.0);
    return std::acos(cosine) * 180 / M_PI > options.horizontalTolerance;
}

/// Calls addRay(origin, end, kind) for what is to be inserted.
/// \param transformOf(times, i) nullptr: no pose is known
template <int Dim, class TransformOf, class AddRay>
void forEachRay(const SensorReturns& returns, const CellGeometry<Dim>& geometry,
                const TInsertionOptions& options, TInsertionReport& report,
                TransformOf transformOf, AddRay addRay) {
    const bool isColumn = Dim == 2 && !returns.planar;
    const RayCutter<Dim> cutter(options, geometry, isColumn);
    const bool dropOutOfBand = !isColumn;
    const auto add = [&](const std::vector<Eigen::Vector3f>& points,
                         const std::vector<float>& times, RayEnd kind) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Transform* transform = transformOf(i < times.size() ? times[i] : 0.0f);
            if (!transform) {
                ++report.withoutPose;
                continue;
            }
            if (isTilted<Dim>(returns, *transform, options)) {
                ++report.tilted;
                continue;
            }
            const Eigen::Vector3d p_map = (*transform)(points[i]);
            // NaN passes both tests; the bundle skips and counts it.
            if (dropOutOfBand &&
                (p_map.z() < options.heightBandMin || p_map.z() > options.heightBandMax)) {
                ++report.outOfHeightBand;
                continue;
            }
            if (!cutter.isNeeded()) {
                addRay(transform->t, p_map, kind);
            } else if (const auto part = cutter.cut(transform->t, p_map, kind, report)) {
                addRay(part->from, part->to, part->kind);
            }
        }
    };
    add(returns.hits, returns.hitTimes, RayEnd::hit);
    add(returns.noReturns, returns.noReturnTimes, RayEnd::noReturn);
    report.noReturns += returns.noReturnCount;
}

/// The limits that are left to the bundle.
template <int Dim>
RangeLimits bundleLimits(const SensorReturns& returns, const CellGeometry<Dim>& geometry,
                         const TInsertionOptions& options) {
    const bool cutBefore =
        RayCutter<Dim>(options, geometry, Dim == 2 && !returns.planar).isNeeded();
    return cutBefore ? RangeLimits{} : options.rangeLimits();
}

}  // namespace

template <int Dim>
RayBundle<Dim> toRays(const SensorReturns& returns, const mrpt::poses::CPose3D& T_map_robot,
                      const CellGeometry<Dim>& geometry, const TInsertionOptions& options,
                      TInsertionReport& report) {
    const Transform T_map_sensor(T_map_robot + returns.sensorOnRobot);
    RayBundle<Dim> rays(geometry, T_map_sensor.t.template head<Dim>(),
                        bundleLimits(returns, geometry, options));
    rays.reserve(returns.hits.size() + returns.noReturns.size());
    // Returns are handed over in batches, in order.
    constexpr std::size_t kBatch = 256;
    std::vector<Point<Dim>> batch;
    batch.reserve(kBatch);
    const auto handOver = [&] {
        if (!batch.empty()) rays.addReturns(batch.data()->data(), batch.size());
        batch.clear();
    };
    forEachRay(
        returns, geometry, options, report, [&](float) { return &T_map_sensor; },
        [&](const Eigen::Vector3d& from, const Eigen::Vector3d& p_map, RayEnd kind) {
            const Point<Dim> origin = from.template head<Dim>();
            const bool ownOrigin = origin != rays.commonOrigin();
            if (kind == RayEnd::hit && !ownOrigin) {
                batch.push_back(p_map.template head<Dim>());
                if (batch.size() == kBatch) handOver();
                return;
            }
            handOver();
            if (ownOrigin)
                rays.add(origin, p_map.template head<Dim>(), kind);
            else
                rays.add(p_map.template head<Dim>(), kind);
        });
    handOver();
    report.skipped += rays.skipped();
    return rays;
}

template <int Dim>
RayBundle<Dim> toRaysAlong(const SensorReturns& returns, mrpt::Clock::time_point timestamp,
                           const PoseAtTime& T_map_robot, const CellGeometry<Dim>& geometry,
                           const TInsertionOptions& options, TInsertionReport& report) {
    MovingSensor sensor(returns, timestamp, T_map_robot);
    const RangeLimits limits = bundleLimits(returns, geometry, options);
    // The common origin is where the sensor is at the first measurement that has a pose. (Rays
    // may begin elsewhere, where they come into the height band.)
    std::optional<Point<Dim>> first;
    std::optional<RayBundle<Dim>> rays;
    forEachRay(
        returns, geometry, options, report,
        [&](float seconds) {
            report.timedRays += seconds != 0;
            const Transform* const T_map_sensor = sensor.at(seconds);
            if (!first && T_map_sensor) first = T_map_sensor->t.template head<Dim>();
            return T_map_sensor;
        },
        [&](const Eigen::Vector3d& from, const Eigen::Vector3d& p_map, RayEnd kind) {
            const Point<Dim> origin = from.template head<Dim>();
            if (!rays) {
                rays.emplace(geometry, *first, limits);
                rays->reserve(returns.hits.size() + returns.noReturns.size());
            }
            rays->add(origin, p_map.template head<Dim>(), kind);
        });
    if (!rays) return RayBundle<Dim>(geometry, Point<Dim>::Zero(), limits);
    report.skipped += rays->skipped();
    return *std::move(rays);
}

#define SUPERRAY_INSTANTIATE(Dim)                                                      \
    template RayBundle<Dim> toRays(const SensorReturns&, const mrpt::poses::CPose3D&,  \
                                   const CellGeometry<Dim>&, const TInsertionOptions&, \
                                   TInsertionReport&);                                 \
    template RayBundle<Dim> toRaysAlong(const SensorReturns&, mrpt::Clock::time_point, \
                                        const PoseAtTime&, const CellGeometry<Dim>&,   \
                                        const TInsertionOptions&, TInsertionReport&);
SUPERRAY_INSTANTIATE(2)
SUPERRAY_INSTANTIATE(3)
#undef SUPERRAY_INSTANTIATE

}  // namespace superray
