// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_matching.h
/// How well points agree with a map.

#include <mrpt/maps/CMetricMap.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/tfest/TMatchingPair.h>
#include <superray/maps/options.h>
#include <superray/maps/surface_statistics.h>
#include <superray/storage/occupancy_map.h>

namespace superray {

/// See CSuperRayMapBase::compute3DMatchingRatio().
template <int Dim>
float matchingRatio(const OccupancyMap<Dim>& map, const SensorModel& model,
                    const mrpt::maps::CMetricMap* other, const mrpt::poses::CPose3D& otherPose,
                    const mrpt::maps::TMatchingRatioParams& params);

/// See CSuperRayMapBase::determineMatching3D(). Occupied cells farther than 32
/// cells from a point are not found.
/// \param statistics where the surface lies in the cells; null: not known
/// \throws std::invalid_argument for parameters that contradict each other, or
///         another map that has no points
template <int Dim>
void matchPoints(const OccupancyMap<Dim>& map, const SurfaceStatistics<Dim>* statistics,
                 const SensorModel& model, const mrpt::maps::CMetricMap* other,
                 const mrpt::poses::CPose3D& otherPose,
                 const mrpt::maps::TMatchingParams& params,
                 mrpt::tfest::TMatchingPairList& correspondences,
                 mrpt::maps::TMatchingExtraResults& extraResults);

}  // namespace superray
