// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/gzip_output.h>
#include <superray/maps/super_ray_map_base.h>

#include <mrpt/img/CImage.h>
#include <mrpt/io/lazy_load_path.h>
#include <mrpt/obs/CObservation.h>
#include <superray/maps/observation_rays.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <sstream>
#include <stdexcept>

#include "matching/likelihood.h"
#include "matching/map_matching.h"
#include "queries/obstacle_search.h"
#include "views/map_export.h"
#include "views/voxel_view.h"

namespace superray {
namespace {

/// Tells MRPT where externally stored observations are.
void useLazyLoadPath(const std::string& folder) {
    if (folder.empty()) return;
    const std::string path = std::filesystem::absolute(folder).string();
    mrpt::io::setLazyLoadPathBase(path);
    mrpt::img::CImage::setImagesPathBase(path);
}

}  // namespace

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
      reserveMegabytes_(other.reserveMegabytes_),
      maxMegabytes_(other.maxMegabytes_),
      storage_(other.storage_),
      surface_(other.surface_),
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
    reserveMegabytes_ = other.reserveMegabytes_;
    maxMegabytes_ = other.maxMegabytes_;
    storage_ = other.storage_;
    surface_ = other.surface_;
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
bool CSuperRayMapBase<Dim>::changeResolution(double metres) {
    if (metres == resolution()) return false;
    if (!isEmpty())
        throw std::logic_error(shortClassName() + ": the resolution of a map with contents (" +
                               metresText(resolution()) + ") cannot be changed to " +
                               metresText(metres) + "; clear() it first");
    storage_ = makeEmptyStorage(metres);
    contentsChanged();
    return true;
}

template <int Dim>
void CSuperRayMapBase<Dim>::setResolution(double metres) {
    if (changeResolution(metres)) reserveMemory();
}

template <int Dim>
TMapOptions CSuperRayMapBase<Dim>::options() const {
    TMapOptions o;
    o.creation.resolution = resolution();
    o.creation.reserve_megabytes = reserveMegabytes_;
    o.creation.max_memory_megabytes = maxMegabytes_;
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
    o.validate();
    useLazyLoadPath(o.creation.lazy_load_path);
    bool reserving = o.creation.reserve_megabytes != reserveMegabytes_;
    if (o.creation.load_from.empty()) {
        if (!isEmpty())
            requireWithin(o.creation.max_memory_megabytes, heldBytes(), "this map as it is");
        else if (o.creation.max_memory_megabytes != 0 && reserving)
            storage_ = makeEmptyStorage(resolution());  // without the reserve of before
        reserving |= changeResolution(o.creation.resolution);
    } else {
        loadWithin(o.creation.load_from, o.creation.max_memory_megabytes);
        reserving = true;
    }
    assignOptions(o);
    if (reserving) reserveMemory();
}

template <int Dim>
void CSuperRayMapBase<Dim>::assignOptions(const TMapOptions& o) {
    reserveMegabytes_ = o.creation.reserve_megabytes;
    maxMegabytes_ = o.creation.max_memory_megabytes;
    genericMapParams.enableSaveAs3DObject = o.creation.enableSaveAs3DObject;
    genericMapParams.enableObservationLikelihood = o.creation.enableObservationLikelihood;
    genericMapParams.enableObservationInsertion = o.creation.enableObservationInsertion;
    insertionOptions = o.insertion;
    likelihoodOptions = o.likelihood;
    renderingOptions = o.rendering;
}

template <int Dim>
void CSuperRayMapBase<Dim>::replaceAll(SharedStorage<Dim> storage, TMapOptions o,
                                       std::uint32_t boundMegabytes) {
    std::uint32_t& bound = o.creation.max_memory_megabytes;
    if (boundMegabytes != 0)
        bound = bound == 0 ? boundMegabytes : std::min(bound, boundMegabytes);
    if (bound != 0)
        requireWithin(bound,
                      storage->heldBytes() +
                          companionBytesOf(*storage, o.insertion.sensorModel().occupied()),
                      "the map to be loaded");
    assignOptions(o);
    storage_ = std::move(storage);
    surface_.reset();
    last_ = totals_ = {};
    contentsChanged();
}

template <int Dim>
void CSuperRayMapBase<Dim>::reserveMemory() {
    if (reserveMegabytes_ == 0) return;
    // The number may come from a file: it must not take the machine's memory.
    const std::size_t bytes = std::min<std::size_t>(std::size_t{reserveMegabytes_} << 20,
                                                    MapFileLimits::ofThisMachine().mapBytes);
    integrator_.reserve(bytes / 4, insertionOptions.integratorOptions().threads);
    std::size_t forCells = bytes - bytes / 4;
    if (maxMegabytes_ != 0) {
        const std::size_t bound = std::size_t{maxMegabytes_} << 20, held = heldBytes();
        // A reserve is about so large.
        forCells = std::min(forCells, (bound - std::min(bound, held)) / 8 * 7);
    }
    storage_.writable().reserve(forCells);
}

// --- changes ------------------------------------------------------------------

template <int Dim>
void CSuperRayMapBase<Dim>::contentsChanged() {
    changes_.everything();
    view_->forget();
}

// --- contents ---------------------------------------------------------------

template <int Dim>
void CSuperRayMapBase<Dim>::internal_clear() {
    storage_.clear();
    surface_.reset();
    last_ = totals_ = {};
    contentsChanged();
    reserveMemory();
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
    matchPoints(*storage_, surface_.get(), sensorModel(), other, otherPose, params,
                correspondences, extraResults);
}

template <int Dim>
void CSuperRayMapBase<Dim>::determineMatching2D(
    const mrpt::maps::CMetricMap* other, const mrpt::poses::CPose2D& otherPose,
    mrpt::tfest::TMatchingPairList& correspondences, const mrpt::maps::TMatchingParams& params,
    mrpt::maps::TMatchingExtraResults& extraResults) const {
    matchPoints(*storage_, surface_.get(), sensorModel(), other,
                mrpt::poses::CPose3D(otherPose), params, correspondences, extraResults);
}

// --- views --------------------------------------------------------------------

template <int Dim>
std::shared_ptr<mrpt_viz::COctoMapVoxels> CSuperRayMapBase<Dim>::visualization() const {
    return view_->draw(*storage_, sensorModel(), renderingOptions);
}

template <int Dim>
void CSuperRayMapBase<Dim>::getVisualizationInto(mrpt_viz::CSetOfObjects& objects) const {
    if (genericMapParams.enableSaveAs3DObject) objects.insert(visualization());
}

template <int Dim>
void CSuperRayMapBase<Dim>::exportScene(const std::string& path) const {
    GlScene scene;
    scene.insert(visualization());
    writeGzip(scene, path);
}

template <int Dim>
void CSuperRayMapBase<Dim>::exportPly(const std::string& path) const {
    writePly(*storage_, sensorModel(), path);
}

template class CSuperRayMapBase<2>;
template class CSuperRayMapBase<3>;

}  // namespace superray
