// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/CSuperRayPointsMap.h>

#include <superray/storage/memory_limit_error.h>

#include <new>
#include <stdexcept>
#include <string>

#include "mrpt/points_map_occupancy.h"

namespace superray {

template <int Dim>
CSuperRayPointsMap<Dim>::CSuperRayPointsMap(double resolution)
    : occupancy_(std::make_unique<Occupancy>(*this, resolution)) {}

template <int Dim>
CSuperRayPointsMap<Dim>::~CSuperRayPointsMap() = default;

template <int Dim>
CSuperRayPointsMap<Dim>::CSuperRayPointsMap(const CSuperRayPointsMap& other)
    : AssignablePointsMap(),
      occupancy_(std::make_unique<Occupancy>(*this, other.occupancy_->resolution())) {
    copyAll(other);
}

template <int Dim>
CSuperRayPointsMap<Dim>& CSuperRayPointsMap<Dim>::operator=(const CSuperRayPointsMap& other) {
    if (this != &other) copyAll(other);
    return *this;
}

template <int Dim>
void CSuperRayPointsMap<Dim>::assignFrom(const mrpt::maps::CPointsMap& other) {
    const auto* same = dynamic_cast<const CSuperRayPointsMap*>(&other);
    if (!same)
        throw std::invalid_argument("CSuperRayPointsMap" + std::to_string(Dim) +
                                    "D: cannot be copied from another class of points map, "
                                    "which has no occupancy");
    operator=(*same);
}

template <int Dim>
void CSuperRayPointsMap<Dim>::copyAll(const CSuperRayPointsMap& other) {
    decltype(blocks_) blocks;
    for (const auto& [key, points] : other.blocks_)
        blocks.emplace(key, std::make_unique<BlockPoints>(*points));
    auto sources = other.sources_;
    occupancy_->takeFrom(*other.occupancy_);
    copyPoints(other);
    sources_ = std::move(sources);
    blocks_ = std::move(blocks);
}

// --- the map ------------------------------------------------------------------

/// Memory may run out anywhere in `change`: then there are points made anew from the
/// cells, or none (the next scan makes them).
template <int Dim>
template <class Change>
void CSuperRayPointsMap<Dim>::remakeOnFailure(const Change& change) {
    try {
        change();
    } catch (const MemoryLimitError&) {
        throw;  // nothing has changed
    } catch (...) {
        forgetPoints();
        try {
            followAllBlocks();
        } catch (const std::bad_alloc&) {
            forgetPoints();
        }
        throw;
    }
}

template <int Dim>
const typename CSuperRayPointsMap<Dim>::GridMap& CSuperRayPointsMap<Dim>::occupancy() const {
    return *occupancy_;
}

template <int Dim>
bool CSuperRayPointsMap<Dim>::isEmpty() const {
    return occupancy_->isEmpty();
}

template <int Dim>
void CSuperRayPointsMap<Dim>::setOptions(const TMapOptions& options) {
    occupancy_->setOptions(options);
    genericMapParams = occupancy_->genericMapParams;
    if (!options.creation.load_from.empty()) forgetPoints();
    // Another threshold, another set of occupied cells.
    remakeOnFailure([this] { followAllBlocks(); });
}

template <int Dim>
void CSuperRayPointsMap<Dim>::loadFromFile(const std::string& path) {
    occupancy_->loadFromFile(path);
    genericMapParams = occupancy_->genericMapParams;
    forgetPoints();
    remakeOnFailure([this] { followAllBlocks(); });
}

template <int Dim>
std::string CSuperRayPointsMap<Dim>::asString() const {
    return std::to_string(size()) + " occupied cells as points, of " + occupancy_->asString();
}

template <int Dim>
void CSuperRayPointsMap<Dim>::getVisualizationInto(mrpt_viz::CSetOfObjects& objects) const {
    if (genericMapParams.enableSaveAs3DObject) occupancy_->getVisualizationInto(objects);
}

template <int Dim>
void CSuperRayPointsMap<Dim>::saveMetricMapRepresentationToFile(
    const std::string& prefix) const {
    occupancy_->saveMetricMapRepresentationToFile(prefix);
}

template <int Dim>
double CSuperRayPointsMap<Dim>::internal_computeObservationLikelihood(
    const mrpt::obs::CObservation& observation, const mrpt::poses::CPose3D& robotPose) const {
    return occupancy_->computeObservationLikelihood(observation, robotPose);
}

template <int Dim>
bool CSuperRayPointsMap<Dim>::internal_canComputeObservationLikelihood(
    const mrpt::obs::CObservation& observation) const {
    return occupancy_->canComputeObservationLikelihood(observation);
}

template <int Dim>
void CSuperRayPointsMap<Dim>::internal_clear() {
    occupancy_->clear();
    forgetPoints();
}

template <int Dim>
bool CSuperRayPointsMap<Dim>::internal_insertObservation(
    const mrpt::obs::CObservation& observation,
    const std::optional<const mrpt::poses::CPose3D>& robotPose) {
    occupancy_->genericMapParams = genericMapParams;
    try {
        // Calls prepare() and follow().
        return occupancy_->insertObservation(observation, robotPose);
    } catch (...) {
        forgetLostBlocks();
        throw;
    }
}

template class CSuperRayPointsMap<2>;
template class CSuperRayPointsMap<3>;

}  // namespace superray
