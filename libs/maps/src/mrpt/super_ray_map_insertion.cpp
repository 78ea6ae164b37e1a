// SPDX-License-Identifier: BSD-3-Clause
// Scans into the map.

#include <mrpt/poses/CPose3DInterpolator.h>
#include <superray/core/reference_mapper.h>
#include <superray/core/stopwatch.h>
#include <superray/maps/observation_rays.h>
#include <superray/maps/pose_track.h>
#include <superray/maps/super_ray_map_base.h>
#include <superray/storage/memory_limit_error.h>

#include <chrono>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <utility>

#include "mrpt/return_columns.h"
#include "views/voxel_view.h"

namespace superray {

template <int Dim>
void CSuperRayMapBase<Dim>::recordChange(const UpdateBatch<Dim>& batch) {
    if (!changes_.recording()) return;
    for (std::size_t b = 0; b < batch.blockCount(); ++b) changes_.add(batch.key(b));
}

template <int Dim>
void CSuperRayMapBase<Dim>::recordChange(const CellCountMap<Dim>& counts) {
    if (!changes_.recording()) return;
    for (const auto& entry : counts) changes_.add(blockOf<Dim>(entry.first));
}

namespace {

/// What a radius [m] leaves of the map around a scan's sensor; nothing: all of it.
template <int Dim>
std::optional<BlockWindow<Dim>> windowAround(const RayBundle<Dim>& rays, double radius) {
    if (radius <= 0) return std::nullopt;
    const CellGeometry<Dim>& geometry = rays.geometry();
    return BlockWindow<Dim>(blockOf<Dim>(geometry.cellOf(rays.commonOrigin())), radius,
                            geometry.resolution());
}

/// What a scan changes in a window. \return a batch that borrows the counts
template <int Dim>
UpdateBatch<Dim> withinWindow(const UpdateBatch<Dim>& batch, const BlockWindow<Dim>& window) {
    UpdateBatch<Dim> within;
    for (std::size_t b = 0; b < batch.blockCount(); ++b)
        if (window.holds(batch.key(b)))
            within.borrowBlock(batch.key(b), batch.misses(b), batch.hits(b));
    return within;
}

template <int Dim>
CellCountMap<Dim> withinWindow(const CellCountMap<Dim>& counts,
                               const BlockWindow<Dim>& window) {
    CellCountMap<Dim> within;
    for (const auto& entry : counts)
        if (window.holds(blockOf<Dim>(entry.first))) within.insert(entry);
    return within;
}

template <int Dim>
void applyTo(OccupancyMap<Dim>& map, const UpdateBatch<Dim>& batch, const SensorModel& model,
             UpdatePolicy policy, unsigned threads) {
    map.apply(batch, model, policy, threads);
}
template <int Dim>
void applyTo(OccupancyMap<Dim>& map, const CellCountMap<Dim>& counts, const SensorModel& model,
             UpdatePolicy policy, unsigned /*threads*/) {
    map.apply(counts, model, policy);
}

}  // namespace

template <int Dim>
template <class ToBundle>
bool CSuperRayMapBase<Dim>::insertReturns(const mrpt::obs::CObservation& observation,
                                          ReturnTimes times, ToBundle toBundle) {
    last_ = {};
    if (!insertionOptions.acceptsSensor(observation.sensorLabel)) return false;
    insertionOptions.validate();
    Stopwatch watch;
    const auto returns = readReturns(
        observation, {insertionOptions.decimation, insertionOptions.insertNoReturnRays,
                      insertionOptions.noReturnRange, times, insertionOptions.sweepDuration});
    if (!returns) return false;
    TInsertionReport report;
    const RayBundle<Dim> rays = toBundle(*returns, report);
    report.toRaysSeconds = watch.lap();
    const bool isColumn = Dim == 2 && !returns->planar;
    integrate(rays, report, isColumn ? HitCells::notMissed : HitCells::missedToo);
    return !rays.empty();
}

template <int Dim>
bool CSuperRayMapBase<Dim>::internal_insertObservation(
    const mrpt::obs::CObservation& observation,
    const std::optional<const mrpt::poses::CPose3D>& robotPose) {
    return insertReturns(observation, ReturnTimes::ignore,
                         [&](const SensorReturns& returns, TInsertionReport& report) {
                             return toRays(returns, robotPose.value_or(mrpt::poses::CPose3D()),
                                           storage_->geometry(), insertionOptions, report);
                         });
}

template <int Dim>
bool CSuperRayMapBase<Dim>::insertObservationAlong(const mrpt::obs::CObservation& observation,
                                                   const PoseAtTime& T_map_robot) {
    if (!genericMapParams.enableObservationInsertion) return false;
    return insertReturns(observation, ReturnTimes::read,
                         [&](const SensorReturns& returns, TInsertionReport& report) {
                             return toRaysAlong(returns, observation.timestamp, T_map_robot,
                                                storage_->geometry(), insertionOptions, report);
                         });
}

namespace {

/// Longest gap to interpolate over [s]: what the trajectory itself says, if it does.
double longestGap(const mrpt::poses::CPose3DInterpolator& trajectory) {
    // MRPT forgot the const of this one.
    const auto limit =
        const_cast<mrpt::poses::CPose3DInterpolator&>(trajectory).getMaxTimeInterpolation();
    const double seconds = std::chrono::duration<double>(limit).count();
    return seconds > 0 ? seconds : kDefaultPoseGap;
}

}  // namespace

bool SuperRayMapInterface::insertObservationAlong(
    const mrpt::obs::CObservation& observation,
    const mrpt::poses::CPose3DInterpolator& trajectory) {
    PoseLimits limits;
    limits.maxGap = longestGap(trajectory);
    return insertObservationAlong(observation, [&](mrpt::Clock::time_point time) {
        std::optional<TimedPose> before, after;
        const auto next = trajectory.lower_bound(time);
        if (next != trajectory.end()) after.emplace(next->first, next->second);
        if (next != trajectory.begin()) {
            const auto last = std::prev(next);
            before.emplace(last->first, last->second);
        }
        return poseBetween(before ? &*before : nullptr, after ? &*after : nullptr, time, limits)
            .pose;
    });
}

template <int Dim>
void CSuperRayMapBase<Dim>::insertRays(const RayBundle<Dim>& rays) {
    if (rays.geometry().resolution() != resolution())
        throw std::invalid_argument(shortClassName() + ": rays made for cells of " +
                                    metresText(rays.geometry().resolution()) + "; must be " +
                                    metresText(resolution()));
    insertionOptions.validate();
    TInsertionReport report;
    report.skipped = rays.skipped();
    integrate(rays, report, HitCells::missedToo);
}

template <int Dim>
SurfaceStatistics<Dim>& CSuperRayMapBase<Dim>::makeOwnStatistics() {
    if (!surface_)
        surface_ = std::make_shared<SurfaceStatistics<Dim>>(storage_->geometry());
    else if (surface_.use_count() > 1)  // copies of this map have it too
        surface_ = std::make_shared<SurfaceStatistics<Dim>>(*surface_);
    return *surface_;
}

template <int Dim>
void CSuperRayMapBase<Dim>::integrate(const RayBundle<Dim>& rays, TInsertionReport report,
                                      HitCells hitCells) {
    report.rays = rays.size();
    if (!rays.empty()) {
        report.scans = 1;
        try {
            applyRays(rays, hitCells, report);
        } catch (const MemoryLimitError&) {
            throw;  // nothing has changed
        } catch (...) {
            // The window may have forgotten a part: what is derived is made anew.
            contentsChanged();
            throw;
        }
    }
    last_ = report;
    totals_ += report;
}

template <int Dim>
void CSuperRayMapBase<Dim>::applyRays(const RayBundle<Dim>& rays, HitCells hitCells,
                                      TInsertionReport& report) {
    const SensorModel model = sensorModel();
    const IntegratorOptions integration = insertionOptions.integratorOptions();
    OccupancyMap<Dim>& map = storage_.writable();
    Stopwatch watch;
    if (ScanIntegrator<Dim>::needsExactCounts(integration, model, &map)) {
        auto counts = countCells(rays);
        if (hitCells == HitCells::notMissed)
            counts = withoutMissesOfHitCells<Dim>(std::move(counts));
        report.integrateSeconds = watch.lap();
        report.work.rays = rays.size();
        requireRoom(counts, rays);
        applyChange(rays, counts, 1, report);
    } else {
        const UpdateBatch<Dim>* batch = &integrator_.integrate(rays, model, integration, &map);
        report.work = integrator_.statistics();
        UpdateBatch<Dim> changed;
        if (hitCells == HitCells::notMissed) {
            changed = withoutMissesOfHitCells<Dim>(*batch);
            batch = &changed;
        }
        report.integrateSeconds = watch.lap();
        applyChange(rays, *batch, requireRoom(*batch, rays), report);
    }
    report.applySeconds = watch.lap();
}

template <int Dim>
template <class Change>
void CSuperRayMapBase<Dim>::applyChange(const RayBundle<Dim>& rays, const Change& change,
                                        unsigned threads, TInsertionReport& report) {
    changes_.begin();
    // What lies outside the window is forgotten first, and of the scan it is left out: so
    // that nothing is left to do that may fail when the scan is in the map.
    const auto window = windowAround(rays, insertionOptions.windowRadius);
    std::optional<Change> within;
    BlockKeys forgotten;
    if (window) {
        within = withinWindow(change, *window);
        forgotten = slideWindow(*window);
    }
    const Change& applied = within ? *within : change;
    recordChange(applied);
    view_->applied(applied);
    std::optional<typename SurfaceStatistics<Dim>::Addition> patches;
    if (insertionOptions.pointStatistics)
        patches.emplace(makeOwnStatistics(), rays, window ? &*window : nullptr);
    scanToCome(applied);
    applyTo(storage_.writable(), applied, sensorModel(), insertionOptions.policy, threads);
    // Nothing fails from here on.
    if (patches) patches->commit();
    scanApplied(rays, forgotten);
    report.forgottenBlocks = forgotten.size();
}

#define SUPERRAY_INSTANTIATE(Dim)                                                           \
    template bool CSuperRayMapBase<Dim>::internal_insertObservation(                        \
        const mrpt::obs::CObservation&, const std::optional<const mrpt::poses::CPose3D>&);  \
    template bool CSuperRayMapBase<Dim>::insertObservationAlong(                            \
        const mrpt::obs::CObservation&, const PoseAtTime&);                                 \
    template void CSuperRayMapBase<Dim>::insertRays(const RayBundle<Dim>&);                 \
    template SurfaceStatistics<Dim>& CSuperRayMapBase<Dim>::makeOwnStatistics();            \
    template void CSuperRayMapBase<Dim>::integrate(const RayBundle<Dim>&, TInsertionReport, \
                                                   HitCells);                               \
    template void CSuperRayMapBase<Dim>::applyRays(const RayBundle<Dim>&, HitCells,         \
                                                   TInsertionReport&);                      \
    template void CSuperRayMapBase<Dim>::recordChange(const UpdateBatch<Dim>&);             \
    template void CSuperRayMapBase<Dim>::recordChange(const CellCountMap<Dim>&);
SUPERRAY_INSTANTIATE(2)
SUPERRAY_INSTANTIATE(3)
#undef SUPERRAY_INSTANTIATE

}  // namespace superray
