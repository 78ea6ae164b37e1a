// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/nearest_neighbors.h>

namespace superray {
namespace {

using mrpt::math::TPoint2Df;
using mrpt::math::TPoint3Df;

NeighborQuery queryAt(const TPoint3Df& p) {
    NeighborQuery query;
    query.point = {p.x, p.y, p.z};
    return query;
}
NeighborQuery queryAt(const TPoint2Df& p) {
    NeighborQuery query;
    query.point = {p.x, p.y, 0};
    query.distance = NeighborDistance::fromAbove;
    return query;
}

void assign(const TPoint3Df& from, TPoint3Df& to) {
    to = from;
}
void assign(const TPoint3Df& from, TPoint2Df& to) {
    to = {from.x, from.y};
}

template <class Point>
bool nearest(const NearestNeighbors& map, const Point& p, Point& result, float& squared,
             std::uint64_t& id) {
    NeighborQuery query = queryAt(p);
    query.most = 1;
    const auto found = map.neighbors(query);
    if (found.empty()) return false;
    assign(found[0].point, result);
    squared = static_cast<float>(found[0].squaredDistance);
    id = found[0].id;
    return true;
}

template <class Point>
void list(const NearestNeighbors& map, const NeighborQuery& query, std::vector<Point>& points,
          std::vector<float>& squared, std::vector<std::uint64_t>& ids) {
    const auto found = map.neighbors(query);
    points.resize(found.size());
    squared.resize(found.size());
    ids.resize(found.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        assign(found[i].point, points[i]);
        squared[i] = static_cast<float>(found[i].squaredDistance);
        ids[i] = found[i].id;
    }
}

template <class Point>
NeighborQuery nearestOf(const Point& p, std::size_t most) {
    NeighborQuery query = queryAt(p);
    query.most = most;
    return query;
}

template <class Point>
NeighborQuery within(const Point& p, float squaredRadius, std::size_t maxPoints) {
    NeighborQuery query = queryAt(p);
    query.squaredRadius = double{squaredRadius};
    if (maxPoints != 0) query.most = maxPoints;
    return query;
}

}  // namespace

void NearestNeighbors::nn_prepare_for_2d_queries() const {
    static_cast<void>(neighbors(nearestOf(TPoint2Df(0, 0), 0)));
}
void NearestNeighbors::nn_prepare_for_3d_queries() const {
    static_cast<void>(neighbors(nearestOf(TPoint3Df(0, 0, 0), 0)));
}

bool NearestNeighbors::nn_single_search(const TPoint3Df& query, TPoint3Df& result,
                                        float& out_dist_sqr,
                                        std::uint64_t& resultIndexOrID) const {
    return nearest(*this, query, result, out_dist_sqr, resultIndexOrID);
}
bool NearestNeighbors::nn_single_search(const TPoint2Df& query, TPoint2Df& result,
                                        float& out_dist_sqr,
                                        std::uint64_t& resultIndexOrID) const {
    return nearest(*this, query, result, out_dist_sqr, resultIndexOrID);
}

void NearestNeighbors::nn_multiple_search(
    const TPoint3Df& query, std::size_t N, std::vector<TPoint3Df>& results,
    std::vector<float>& out_dists_sqr, std::vector<std::uint64_t>& resultIndicesOrIDs) const {
    list(*this, nearestOf(query, N), results, out_dists_sqr, resultIndicesOrIDs);
}
void NearestNeighbors::nn_multiple_search(
    const TPoint2Df& query, std::size_t N, std::vector<TPoint2Df>& results,
    std::vector<float>& out_dists_sqr, std::vector<std::uint64_t>& resultIndicesOrIDs) const {
    list(*this, nearestOf(query, N), results, out_dists_sqr, resultIndicesOrIDs);
}

void NearestNeighbors::nn_radius_search(const TPoint3Df& query, float search_radius_sqr,
                                        std::vector<TPoint3Df>& results,
                                        std::vector<float>& out_dists_sqr,
                                        std::vector<std::uint64_t>& resultIndicesOrIDs,
                                        std::size_t maxPoints) const {
    list(*this, within(query, search_radius_sqr, maxPoints), results, out_dists_sqr,
         resultIndicesOrIDs);
}
void NearestNeighbors::nn_radius_search(const TPoint2Df& query, float search_radius_sqr,
                                        std::vector<TPoint2Df>& results,
                                        std::vector<float>& out_dists_sqr,
                                        std::vector<std::uint64_t>& resultIndicesOrIDs,
                                        std::size_t maxPoints) const {
    list(*this, within(query, search_radius_sqr, maxPoints), results, out_dists_sqr,
         resultIndicesOrIDs);
}

}  // namespace superray
