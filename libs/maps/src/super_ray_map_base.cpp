#include <superray/maps/super_ray_map_base.h>

#include <mrpt/obs/CObservation.h>
#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/poses/CPose3DInterpolator.h>
#include <superray/maps/observation_rays.h>

#include <filesystem>
#include <iostream>
#include <sstream>
#include <stdexcept>

#include "likelihood.h"
#include "map_export.h"
#include "map_matching.h"
#include "obstacle_search.h"
#include "stopwatch.h"
#include "voxel_view.h"

namespace superray {

template <int Dim>
CSuperRayMapBase<Dim>::CSuperRayMapBase(StorageType type, double resolution)
    : type_(type),
      storage_(makeEmptyStorage(resolution)),
      distances_(std::make_unique<DistanceField<Dim>>()),
      obstaclePoints_(std::make_unique<ObstaclePoints<Dim>>()),
      view_(std::make_unique<VoxelView<Dim>>()) {}

template <int Dim>
CSuperRayMapBase<Dim>::~CSuperRayMapBase() = default;

// The integrator, the view, the distances and the points are not copied: they only hold what
// can be made again. Nor is the change log: its stamps are this map's own.
template <int Dim>
CSuperRayMapBase<Dim>::CSuperRayMapBase(const CSuperRayMapBase& other)
    : mrpt::maps::CMetricMap(other),
      SuperRayMapInterface(other),
      insertionOptions(other.insertionOptions),
      likelihoodOptions(other.likelihoodOptions),
      renderingOptions(other.renderingOptions),
      type_(other.type_),
      storage_(other.storage_),
      last_(other.last_),
      totals_(other.totals_),
      distances_(std::make_unique<DistanceField<Dim>>()),
      obstaclePoints_(std::make_unique<ObstaclePoints<Dim>>()),
      view_(std::make_unique<VoxelView<Dim>>()) {}

template <int Dim>
CSuperRayMapBase<Dim>& CSuperRayMapBase<Dim>::operator=(const CSuperRayMapBase& other) {
    if (this == &other) return *this;
    mrpt::maps::CMetricMap::operator=(other);
    insertionOptions = other.insertionOptions;
    likelihoodOptions = other.likelihoodOptions;
    renderingOptions = other.renderingOptions;
    type_ = other.type_;
    storage_ = other.storage_;
    last_ = other.last_;
    totals_ = other.totals_;
    contentsChanged();
    return *this;
}

template <int Dim>
SharedStorage<Dim> CSuperRayMapBase<Dim>::makeEmptyStorage(double metres) const {
    return SharedStorage<Dim>(makeStorage<Dim>(type_, CellGeometry<Dim>(metres)));
}

template <int Dim>
std::string CSuperRayMapBase<Dim>::shortClassName() const {
    const std::string name = GetRuntimeClass()->className;
    return name.substr(name.rfind(':') + 1);
}

template <int Dim>
std::string CSuperRayMapBase<Dim>::asString() const {
    std::ostringstream text;
    text << shortClassName() << ", " << resolution() << " m cells, " << totals_.scans
         << " scans inserted, " << memoryBytes() / 1024 << " KiB";
    return text.str();
}

// --- options ----------------------------------------------------------------

template <int Dim>
void CSuperRayMapBase<Dim>::setResolution(double metres) {
    if (metres == resolution()) return;
    if (!isEmpty())
        throw std::logic_error(shortClassName() + ": the resolution of a map with contents (" +
                               std::to_string(resolution()) + " m) cannot be changed to " +
                               std::to_string(metres) + " m; clear() it first");
    storage_ = makeEmptyStorage(metres);
    contentsChanged();
}

template <int Dim>
TMapOptions CSuperRayMapBase<Dim>::options() const {
    TMapOptions o;
    o.creation.resolution = resolution();
    o.creation.enableSaveAs3DObject = genericMapParams.enableSaveAs3DObject;
    o.creation.enableObservationLikelihood = genericMapParams.enableObservationLikelihood;
    o.creation.enableObservationInsertion = genericMapParams.enableObservationInsertion;
    o.insertion = insertionOptions;
    o.likelihood = likelihoodOptions;
    o.rendering = renderingOptions;
    return o;
}

template <int Dim>
void CSuperRayMapBase<Dim>::setOptions(const TMapOptions& o) {
    o.creation.validate();
    o.insertion.validate();
    o.likelihood.validate();
    if (o.creation.load_from.empty()) {
        setResolution(o.creation.resolution);
    } else {
        loadFromFile(o.creation.load_from);
    }
    assignOptions(o);
}

template <int Dim>
void CSuperRayMapBase<Dim>::assignOptions(const TMapOptions& o) {
    genericMapParams.enableSaveAs3DObject = o.creation.enableSaveAs3DObject;
    genericMapParams.enableObservationLikelihood = o.creation.enableObservationLikelihood;
    genericMapParams.enableObservationInsertion = o.creation.enableObservationInsertion;
    insertionOptions = o.insertion;
    likelihoodOptions = o.likelihood;
    renderingOptions = o.rendering;
}

template <int Dim>
void CSuperRayMapBase<Dim>::replaceAll(SharedStorage<Dim> storage, const TMapOptions& o) {
    assignOptions(o);
    storage_ = std::move(storage);
    last_ = totals_ = {};
    contentsChanged();
}

// --- changes ------------------------------------------------------------------

template <int Dim>
void CSuperRayMapBase<Dim>::contentsChanged() {
    changes_.everything();
    view_->forget();
}

template <int Dim>
void CSuperRayMapBase<Dim>::recordChange(const UpdateBatch<Dim>& batch) {
    changes_.begin();
    if (!changes_.recording()) return;
    for (std::size_t b = 0; b < batch.blockCount(); ++b) changes_.add(batch.key(b));
}

template <int Dim>
void CSuperRayMapBase<Dim>::recordChange(const CellCountMap<Dim>& counts) {
    changes_.begin();
    if (!changes_.recording()) return;
    for (const auto& entry : counts) changes_.add(blockOf<Dim>(entry.first));
}

// --- contents ---------------------------------------------------------------

template <int Dim>
void CSuperRayMapBase<Dim>::internal_clear() {
    storage_.clear();
    last_ = totals_ = {};
    contentsChanged();
}

template <int Dim>
CellTotals CSuperRayMapBase<Dim>::cellTotals() const {
    const auto s = summary();
    return {s.known, s.occupied, s.free};
}

template <int Dim>
std::optional<MetricBounds> CSuperRayMapBase<Dim>::metricBounds() const {
    const auto s = summary();
    if (s.known == 0) return std::nullopt;
    MetricBounds bounds{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    for (int a = 0; a < Dim; ++a) {
        bounds.lowest[a] = s.lowest[a] * resolution();
        bounds.highest[a] = (s.highest[a] + 1) * resolution();
    }
    return bounds;
}

template <int Dim>
mrpt::math::TBoundingBoxf CSuperRayMapBase<Dim>::boundingBox() const {
    const auto bounds = metricBounds();
    if (!bounds) return {};
    const Eigen::Vector3f low = bounds->lowest.template cast<float>();
    const Eigen::Vector3f high = bounds->highest.template cast<float>();
    return {{low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()}};
}

template <int Dim>
template <class ToBundle>
bool CSuperRayMapBase<Dim>::insertReturns(const mrpt::obs::CObservation& observation,
                                          ReturnTimes times, ToBundle toBundle) {
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
    integrate(rays, report);
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

bool SuperRayMapInterface::insertObservationAlong(
    const mrpt::obs::CObservation& observation,
    const mrpt::poses::CPose3DInterpolator& trajectory) {
    return insertObservationAlong(observation, [&](mrpt::Clock::time_point time) {
        mrpt::poses::CPose3D pose;
        bool valid = false;
        trajectory.interpolate(time, pose, valid);
        return valid ? std::optional<mrpt::poses::CPose3D>(pose) : std::nullopt;
    });
}

template <int Dim>
void CSuperRayMapBase<Dim>::insertRays(const RayBundle<Dim>& rays) {
    if (rays.geometry().resolution() != resolution())
        throw std::invalid_argument(shortClassName() + ": rays made for cells of " +
                                    std::to_string(rays.geometry().resolution()) +
                                    " m; must be " + std::to_string(resolution()) + " m");
    TInsertionReport report;
    report.skipped = rays.skipped();
    integrate(rays, report);
}

template <int Dim>
void CSuperRayMapBase<Dim>::integrate(const RayBundle<Dim>& rays, TInsertionReport report) {
    const SensorModel model = sensorModel();
    const IntegratorOptions integration = insertionOptions.integratorOptions();
    report.rays = rays.size();
    if (!rays.empty()) {
        report.scans = 1;
        OccupancyMap<Dim>& map = storage_.writable();
        Stopwatch watch;
        const UpdateBatch<Dim>* applied = nullptr;
        if (ScanIntegrator<Dim>::needsExactCounts(integration, model)) {
            const auto counts = countCells(rays);
            report.integrateSeconds = watch.lap();
            report.work.rays = rays.size();
            recordChange(counts);
            view_->applied(counts);
            map.apply(counts, model, integration.policy);
        } else {
            const auto& batch = integrator_.integrate(rays, model, integration, &map);
            report.integrateSeconds = watch.lap();
            report.work = integrator_.statistics();
            recordChange(batch);
            view_->applied(batch);
            map.apply(batch, model, integration.policy);
            applied = &batch;
        }
        report.applySeconds = watch.lap();
        scanApplied(rays, applied);
    }
    last_ = report;
    totals_ += report;
}

// --- likelihood and matching --------------------------------------------------

template <int Dim>
bool CSuperRayMapBase<Dim>::internal_canComputeObservationLikelihood(
    const mrpt::obs::CObservation& observation) const {
    return insertionOptions.acceptsSensor(observation.sensorLabel) &&
           canReadReturns(observation);
}

template <int Dim>
double CSuperRayMapBase<Dim>::internal_computeObservationLikelihood(
    const mrpt::obs::CObservation& observation, const mrpt::poses::CPose3D& robotPose) const {
    if (!insertionOptions.acceptsSensor(observation.sensorLabel)) return 0;
    likelihoodOptions.validate();
    insertionOptions.validate();
    const auto returns = readReturns(observation, {likelihoodOptions.decimation});
    if (!returns) return 0;
    TInsertionReport report;
    const auto rays =
        toRays(*returns, robotPose, storage_->geometry(), insertionOptions, report);
    return endPointLogLikelihood<Dim>(
        rays, *distances_, {*storage_, changes_, sensorModel().occupied()}, likelihoodOptions);
}

template <int Dim>
float CSuperRayMapBase<Dim>::compute3DMatchingRatio(
    const mrpt::maps::CMetricMap* other, const mrpt::poses::CPose3D& otherPose,
    const mrpt::maps::TMatchingRatioParams& params) const {
    return matchingRatio(*storage_, sensorModel(), other, otherPose, params);
}

template <int Dim>
void CSuperRayMapBase<Dim>::determineMatching3D(
    const mrpt::maps::CMetricMap* other, const mrpt::poses::CPose3D& otherPose,
    mrpt::tfest::TMatchingPairList& correspondences, const mrpt::maps::TMatchingParams& params,
    mrpt::maps::TMatchingExtraResults& extraResults) const {
    matchPoints(*storage_, sensorModel(), other, otherPose, params, correspondences,
                extraResults);
}

template <int Dim>
void CSuperRayMapBase<Dim>::determineMatching2D(
    const mrpt::maps::CMetricMap* other, const mrpt::poses::CPose2D& otherPose,
    mrpt::tfest::TMatchingPairList& correspondences, const mrpt::maps::TMatchingParams& params,
    mrpt::maps::TMatchingExtraResults& extraResults) const {
    matchPoints(*storage_, sensorModel(), other, mrpt::poses::CPose3D(otherPose), params,
                correspondences, extraResults);
}

// --- views --------------------------------------------------------------------

template <int Dim>
std::shared_ptr<mrpt::opengl::COctoMapVoxels> CSuperRayMapBase<Dim>::visualization() const {
    return view_->draw(*storage_, sensorModel(), renderingOptions);
}

template <int Dim>
void CSuperRayMapBase<Dim>::getVisualizationInto(mrpt::opengl::CSetOfObjects& objects) const {
    if (genericMapParams.enableSaveAs3DObject) objects.insert(visualization());
}

template <int Dim>
void CSuperRayMapBase<Dim>::exportScene(const std::string& path) const {
    GlScene scene;
    scene.insert(visualization());
    if (!scene.saveToFile(path)) throw std::runtime_error("cannot write " + path);
}

template <int Dim>
void CSuperRayMapBase<Dim>::exportOctomap(const std::string& path) const {
    if constexpr (Dim == 3) {
        writeOctomap(*storage_, sensorModel(), path);
    } else {
        throw std::invalid_argument("cannot write " + path + ": " + shortClassName() +
                                    " is a 2D map, an OctoMap file holds 3D maps");
    }
}

template <int Dim>
void CSuperRayMapBase<Dim>::exportPly(const std::string& path) const {
    writePly(*storage_, sensorModel(), path);
}

template <int Dim>
void CSuperRayMapBase<Dim>::exportPicture(const std::string& path) const {
    if constexpr (Dim == 2) {
        writePicture(*storage_, sensorModel(), path);
    } else {
        throw std::invalid_argument("cannot write " + path + ": " + shortClassName() +
                                    " is a 3D map, a picture shows 2D maps");
    }
}

template class CSuperRayMapBase<2>;
template class CSuperRayMapBase<3>;

}  // namespace superray
