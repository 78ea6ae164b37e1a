// SPDX-License-Identifier: BSD-3-Clause
#include "matching/map_matching.h"

#include <mrpt/maps/CPointsMap.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "queries/nearest_occupied.h"

namespace superray {
namespace {

/// The points that a map is or holds; nullptr if none.
const mrpt::maps::CPointsMap* pointsOf(const mrpt::maps::CMetricMap* map) {
    if (!map) return nullptr;
    if (const auto* points = dynamic_cast<const mrpt::maps::CPointsMap*>(map)) return points;
    return map->getAsSimplePointsMap();
}

mrpt::math::TPoint3D pointInMap(const mrpt::maps::CPointsMap& points, std::size_t i,
                                const mrpt::poses::CPose3D& pose) {
    float x = 0, y = 0, z = 0;
    points.getPoint(i, x, y, z);
    mrpt::math::TPoint3D p;
    pose.composePoint(x, y, z, p.x, p.y, p.z);
    return p;
}

template <int Dim>
Point<Dim> asPoint(const mrpt::math::TPoint3D& p) {
    Point<Dim> q;
    q[0] = p.x;
    q[1] = p.y;
    if constexpr (Dim == 3) q[2] = p.z;
    return q;
}

void checkParams(const mrpt::maps::TMatchingParams& params) {
    const auto fail = [](const std::string& rule) {
        throw std::invalid_argument("matching against an occupancy map: " + rule);
    };
    const std::size_t step = params.decimation_other_map_points;
    if (step < 1) fail("decimation_other_map_points = 0; must be >= 1");
    if (params.offset_other_map_points >= step)
        fail("offset_other_map_points = " + std::to_string(params.offset_other_map_points) +
             "; must be < decimation_other_map_points = " + std::to_string(step));
    if (params.onlyUniqueRobust && !params.onlyKeepTheClosest)
        fail("onlyUniqueRobust needs onlyKeepTheClosest");
}

/// How far from a point its partner may be [m]; < 0 or NaN: it has none.
double reachOf(const mrpt::maps::TMatchingParams& params, const mrpt::math::TPoint3D& p) {
    const double angle = double{params.maxAngularDistForCorrespondence};
    const double away = p.distanceTo(params.angularDistPivotPoint);
    // Even an infinite angle spans nothing at the pivot itself.
    const double across = away > 0 || std::isnan(angle) ? angle * away : 0;
    return double{params.maxDistForCorrespondence} + across;
}

/// What a point is paired with.
template <int Dim>
struct Partner {
    Cell<Dim> cell;
    Point<Dim> point;
    double distance;  ///< that must be within reach [m]
};

/// The surface in an occupied cell where it is known, else the cell itself.
template <int Dim>
Partner<Dim> partnerIn(const typename NearestOccupied<Dim>::Found& found, const Point<Dim>& p,
                       const CellGeometry<Dim>& geometry,
                       const SurfaceStatistics<Dim>* statistics) {
    const auto* patch = statistics ? statistics->patch(found.cell) : nullptr;
    if (!patch) return {found.cell, geometry.center(found.cell), found.distance};
    Point<Dim> foot = patch->footPoint(p);
    // A plane says nothing far from its cell.
    if ((foot - patch->mean).squaredNorm() > Dim * std::pow(geometry.resolution(), 2))
        foot = patch->mean;
    return {found.cell, foot, (foot - p).norm()};
}

}  // namespace

template <int Dim>
float matchingRatio(const OccupancyMap<Dim>& map, const SensorModel& model,
                    const mrpt::maps::CMetricMap* other, const mrpt::poses::CPose3D& otherPose,
                    const mrpt::maps::TMatchingRatioParams& params) {
    const auto* points = pointsOf(other);
    if (!points || points->empty()) return 0;
    const NearestOccupied<Dim> nearest(map, model.occupied(), double{params.maxDistForCorr});
    std::size_t matched = 0;
    for (std::size_t i = 0; i < points->size(); ++i) {
        const Point<Dim> p = asPoint<Dim>(pointInMap(*points, i, otherPose));
        if (map.geometry().contains(p) && nearest(p)) ++matched;
    }
    return static_cast<float>(matched) / static_cast<float>(points->size());
}

template <int Dim>
void matchPoints(const OccupancyMap<Dim>& map, const SurfaceStatistics<Dim>* statistics,
                 const SensorModel& model, const mrpt::maps::CMetricMap* other,
                 const mrpt::poses::CPose3D& otherPose,
                 const mrpt::maps::TMatchingParams& params,
                 mrpt::tfest::TMatchingPairList& correspondences,
                 mrpt::maps::TMatchingExtraResults& extraResults) {
    correspondences.clear();
    extraResults = {};
    checkParams(params);
    const auto* points = pointsOf(other);
    if (!points)
        throw std::invalid_argument(
            "matching against an occupancy map: the other map must be, or hold, a points map");
    const std::size_t step = params.decimation_other_map_points;
    double farthest = -1;
    std::size_t asked = 0;
    for (std::size_t i = params.offset_other_map_points; i < points->size(); i += step, ++asked)
        farthest = std::max(farthest, reachOf(params, pointInMap(*points, i, otherPose)));
    if (asked == 0) return;
    const NearestOccupied<Dim> nearest(map, model.occupied(), farthest);

    std::unordered_map<Cell<Dim>, std::uint32_t, IndexHash> cellNumbers;
    double squaredSum = 0;
    for (std::size_t i = params.offset_other_map_points; i < points->size(); i += step) {
        const auto p = pointInMap(*points, i, otherPose);
        const Point<Dim> q = asPoint<Dim>(p);
        if (!map.geometry().contains(q)) continue;
        const auto found = nearest(q);
        if (!found) continue;
        const auto partner = partnerIn(*found, q, map.geometry(), statistics);
        if (!(partner.distance <= reachOf(params, p))) continue;
        const auto number =
            cellNumbers.emplace(partner.cell, static_cast<std::uint32_t>(cellNumbers.size()));
        mrpt::tfest::TMatchingPair pair;
        pair.globalIdx = number.first->second;
        pair.localIdx = static_cast<std::uint32_t>(i);
        pair.global = {static_cast<float>(partner.point[0]),
                       static_cast<float>(partner.point[1]),
                       static_cast<float>(Dim == 3 ? partner.point[Dim - 1] : p.z)};
        points->getPoint(i, pair.local.x, pair.local.y, pair.local.z);
        const double squared = (partner.point - q).squaredNorm();
        pair.errorSquareAfterTransformation = static_cast<float>(squared);
        squaredSum += squared;
        correspondences.push_back(pair);
    }
    // As CPointsMap does, before pairs are dropped for having the same partner.
    const auto matched = static_cast<double>(correspondences.size());
    extraResults.correspondencesRatio =
        static_cast<float>(matched / static_cast<double>(asked));
    if (matched > 0) extraResults.sumSqrDist = static_cast<float>(squaredSum / matched);
    if (params.onlyUniqueRobust) {
        mrpt::tfest::TMatchingPairList unique;
        correspondences.filterUniqueRobustPairs(cellNumbers.size(), unique);
        correspondences.swap(unique);
    }
}

#define SUPERRAY_INSTANTIATE(Dim)                                                              \
    template float matchingRatio(const OccupancyMap<Dim>&, const SensorModel&,                 \
                                 const mrpt::maps::CMetricMap*, const mrpt::poses::CPose3D&,   \
                                 const mrpt::maps::TMatchingRatioParams&);                     \
    template void matchPoints(const OccupancyMap<Dim>&, const SurfaceStatistics<Dim>*,         \
                              const SensorModel&, const mrpt::maps::CMetricMap*,               \
                              const mrpt::poses::CPose3D&, const mrpt::maps::TMatchingParams&, \
                              mrpt::tfest::TMatchingPairList&,                                 \
                              mrpt::maps::TMatchingExtraResults&);
SUPERRAY_INSTANTIATE(2)
SUPERRAY_INSTANTIATE(3)
#undef SUPERRAY_INSTANTIATE

}  // namespace superray
