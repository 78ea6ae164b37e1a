#include "map_matching.h"

#include <mrpt/maps/CPointsMap.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <unordered_map>

#include "nearest_occupied.h"

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
void matchPoints(const OccupancyMap<Dim>& map, const SensorModel& model,
                 const mrpt::maps::CMetricMap* other, const mrpt::poses::CPose3D& otherPose,
                 const mrpt::maps::TMatchingParams& params,
                 mrpt::tfest::TMatchingPairList& correspondences,
                 mrpt::maps::TMatchingExtraResults& extraResults) {
    correspondences.clear();
    extraResults = {};
    const auto* points = pointsOf(other);
    if (!points)
        throw std::invalid_argument(
            "matching against an occupancy map: the other map must be, or hold, a points map");
    const std::size_t step = std::max<std::size_t>(1, params.decimation_other_map_points);
    const auto reachOf = [&](const mrpt::math::TPoint3D& p) {
        return params.maxDistForCorrespondence + params.maxAngularDistForCorrespondence *
                                                     p.distanceTo(params.angularDistPivotPoint);
    };
    double farthest = 0;
    for (std::size_t i = params.offset_other_map_points; i < points->size(); i += step)
        farthest = std::max(farthest, reachOf(pointInMap(*points, i, otherPose)));
    const NearestOccupied<Dim> nearest(map, model.occupied(), farthest);

    std::unordered_map<Cell<Dim>, std::uint32_t, IndexHash> cellNumbers;
    double squaredSum = 0;
    for (std::size_t i = params.offset_other_map_points; i < points->size(); i += step) {
        const auto p = pointInMap(*points, i, otherPose);
        const Point<Dim> q = asPoint<Dim>(p);
        if (!map.geometry().contains(q)) continue;
        const auto found = nearest(q);
        if (!found || found->distance > reachOf(p)) continue;
        const Point<Dim> centre = map.geometry().center(found->cell);
        const auto number =
            cellNumbers.emplace(found->cell, static_cast<std::uint32_t>(cellNumbers.size()));
        mrpt::tfest::TMatchingPair pair;
        pair.globalIdx = number.first->second;
        pair.localIdx = static_cast<std::uint32_t>(i);
        pair.global = {static_cast<float>(centre[0]), static_cast<float>(centre[1]),
                       static_cast<float>(Dim == 3 ? centre[Dim - 1] : p.z)};
        points->getPoint(i, pair.local.x, pair.local.y, pair.local.z);
        const double squared = (centre - q).squaredNorm();
        pair.errorSquareAfterTransformation = static_cast<float>(squared);
        squaredSum += squared;
        correspondences.push_back(pair);
    }
    if (params.onlyUniqueRobust) {
        mrpt::tfest::TMatchingPairList unique;
        correspondences.filterUniqueRobustPairs(cellNumbers.size(), unique);
        correspondences.swap(unique);
    }
    const std::size_t asked =
        points->size() > params.offset_other_map_points
            ? (points->size() - params.offset_other_map_points + step - 1) / step
            : 0;
    if (asked > 0)
        extraResults.correspondencesRatio =
            static_cast<float>(correspondences.size()) / static_cast<float>(asked);
    if (!correspondences.empty())
        extraResults.sumSqrDist =
            static_cast<float>(squaredSum / static_cast<double>(correspondences.size()));
}

#define SUPERRAY_INSTANTIATE(Dim)                                                            \
    template float matchingRatio(const OccupancyMap<Dim>&, const SensorModel&,               \
                                 const mrpt::maps::CMetricMap*, const mrpt::poses::CPose3D&, \
                                 const mrpt::maps::TMatchingRatioParams&);                   \
    template void matchPoints(                                                               \
        const OccupancyMap<Dim>&, const SensorModel&, const mrpt::maps::CMetricMap*,         \
        const mrpt::poses::CPose3D&, const mrpt::maps::TMatchingParams&,                     \
        mrpt::tfest::TMatchingPairList&, mrpt::maps::TMatchingExtraResults&);
SUPERRAY_INSTANTIATE(2)
SUPERRAY_INSTANTIATE(3)
#undef SUPERRAY_INSTANTIATE

}  // namespace superray
