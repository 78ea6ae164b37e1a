// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file nearest_neighbors.h
/// MRPT's NearestNeighborsCapable, by which matchers (those of MOLA, for one) ask any
/// map for the points near a point.
///
/// The points of a map are the centres of its occupied cells [m, map frame], rounded to
/// single precision, as in getAsSimplePointsMap(); those of 2D maps have z = 0.

#include <mrpt/math/TPoint2D.h>
#include <mrpt/math/TPoint3D.h>
#include <superray/maps/mrpt_compat.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace superray {

/// How far two points are from each other.
enum class NeighborDistance : std::uint8_t {
    inSpace,   ///< with z, also in 2D maps, where the points have z = 0
    fromAbove  ///< in x and y; in 3D maps the cells of a column are equally far
};

/// Which points of a map are asked for: the nearest ones, but no more than `most`.
struct NeighborQuery {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< [m]
    NeighborDistance distance = NeighborDistance::inSpace;
    std::size_t most = std::numeric_limits<std::size_t>::max();
    /// [m^2] points at just this distance are within; < 0: none are
    double squaredRadius = std::numeric_limits<double>::infinity();
};

/// A point of a map near another one.
struct Neighbor {
    mrpt::math::TPoint3Df point;  ///< [m]
    double squaredDistance = 0;   ///< [m^2] from the centre of the cell, in double
    /// The cell: 32768 + its index, 16 bits for each axis, the lowest for x. It stays the
    /// same for as long as the resolution does.
    std::uint64_t id = 0;
};

/// Neighbours are sorted by squared distance, computed in double precision, and among
/// equals by id: the result depends on the map and the query alone. A point that is not
/// finite has none. All may be called concurrently while the map does not change.
class NearestNeighbors : public NearestNeighborsBase {
 public:
    virtual std::vector<Neighbor> neighbors(const NeighborQuery& query) const = 0;

    // NearestNeighborsCapable. Points of the plane ask NeighborDistance::fromAbove.
    /// False: they are ids.
    bool nn_has_indices_or_ids() const SUPERRAY_OVERRIDE_SINCE_2_11_3 { return false; }
    /// 0, as with all maps that have ids.
    std::size_t nn_index_count() const SUPERRAY_OVERRIDE_SINCE_2_11_3 { return 0; }
    /// Takes over the changes since the last question, which otherwise the first does.
    void nn_prepare_for_2d_queries() const SUPERRAY_OVERRIDE_SINCE_2_11_3;
    void nn_prepare_for_3d_queries() const SUPERRAY_OVERRIDE_SINCE_2_11_3;
    bool nn_single_search(const mrpt::math::TPoint3Df& query, mrpt::math::TPoint3Df& result,
                          float& out_dist_sqr,
                          std::uint64_t& resultIndexOrID) const SUPERRAY_OVERRIDE_SINCE_2_11_3;
    bool nn_single_search(const mrpt::math::TPoint2Df& query, mrpt::math::TPoint2Df& result,
                          float& out_dist_sqr,
                          std::uint64_t& resultIndexOrID) const SUPERRAY_OVERRIDE_SINCE_2_11_3;
    void nn_multiple_search(
        const mrpt::math::TPoint3Df& query, std::size_t N,
        std::vector<mrpt::math::TPoint3Df>& results, std::vector<float>& out_dists_sqr,
        std::vector<std::uint64_t>& resultIndicesOrIDs) const SUPERRAY_OVERRIDE_SINCE_2_11_3;
    void nn_multiple_search(
        const mrpt::math::TPoint2Df& query, std::size_t N,
        std::vector<mrpt::math::TPoint2Df>& results, std::vector<float>& out_dists_sqr,
        std::vector<std::uint64_t>& resultIndicesOrIDs) const SUPERRAY_OVERRIDE_SINCE_2_11_3;
    /// \param maxPoints 0: all
    void nn_radius_search(const mrpt::math::TPoint3Df& query, float search_radius_sqr,
                          std::vector<mrpt::math::TPoint3Df>& results,
                          std::vector<float>& out_dists_sqr,
                          std::vector<std::uint64_t>& resultIndicesOrIDs,
                          std::size_t maxPoints = 0) const SUPERRAY_OVERRIDE_SINCE_2_11_3;
    void nn_radius_search(const mrpt::math::TPoint2Df& query, float search_radius_sqr,
                          std::vector<mrpt::math::TPoint2Df>& results,
                          std::vector<float>& out_dists_sqr,
                          std::vector<std::uint64_t>& resultIndicesOrIDs,
                          std::size_t maxPoints = 0) const SUPERRAY_OVERRIDE_SINCE_2_11_3;
};

}  // namespace superray
