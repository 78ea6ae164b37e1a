// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Points into a bundle: from x y z x y z ... into an array per axis, with their
// bounds.

#include "kernels/point_kernels.h"
#include "kernels/simd/lanes.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

/// `lanes` points in a row, 3 coordinates each, are 3 vectors. Coordinate
/// `axis` of point i is element 3 * i + axis of them. Since 3 and `lanes` have
/// no common factor, the elements of one axis are all in different lanes: one
/// vector can be blended from three, and then put in order.
template <int axis, int lanes>
constexpr int vectorWithLane(int lane) {
    for (int i = 0; i < lanes; ++i)
        if ((3 * i + axis) % lanes == lane) return (3 * i + axis) / lanes;
    return -1;
}

/// Coordinate `axis` of the points in a, b, c.
template <int axis, typename Vector, std::size_t... lane>
SUPERRAY_INLINE Vector pickAxis(const Vector& a, const Vector& b, const Vector& c,
                                std::index_sequence<lane...>) {
    constexpr int kLanes = sizeof...(lane);
    const Vector ab = __builtin_shufflevector(
        a, b,
        (vectorWithLane<axis, kLanes>(int{lane}) == 1 ? kLanes + int{lane} : int{lane})...);
    const Vector abc = __builtin_shufflevector(
        ab, c,
        (vectorWithLane<axis, kLanes>(int{lane}) == 2 ? kLanes + int{lane} : int{lane})...);
    return __builtin_shufflevector(abc, abc, (3 * int{lane} + axis) % kLanes...);
}

template <typename Vector, typename Value>
SUPERRAY_INLINE Vector loaded(const Value* from) {
    Vector v;
    std::memcpy(&v, from, sizeof v);
    return v;
}

/// One by one.
template <int Dim, typename Scalar>
inline bool copySomePoints(const Scalar* points, std::size_t begin, std::size_t end,
                           PointBatch<Dim, Scalar>& to) {
    bool good = true;
    for (int a = 0; a < Dim; ++a) {
        Scalar* const out = to.coordinates[static_cast<std::size_t>(a)];
        double low = to.lowest[a], high = to.highest[a];
        for (std::size_t i = begin; i < end; ++i) {
            const Scalar coordinate = points[i * Dim + static_cast<std::size_t>(a)];
            const auto x = static_cast<double>(coordinate);
            out[i] = coordinate;
            good &= x == x;
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        to.lowest[a] = low;
        to.highest[a] = high;
    }
    return good;
}

/// Stores coordinates of one axis and widens the bounds of its lanes. Called per axis:
/// in a loop over the axes, compilers keep the bounds in memory.
template <typename Vector, typename Masks, typename Scalar>
SUPERRAY_INLINE void storeAxis(const Vector& x, Vector& low, Vector& high, Masks& numbers,
                               Scalar* out) {
    numbers &= x == x;
    low = x < low ? x : low;
    high = x > high ? x : high;
    std::memcpy(out, &x, sizeof x);
}

/// \return how many points were copied
template <typename Simd, typename Scalar>
inline std::size_t copyVectors(const Scalar* points, std::size_t count,
                               PointBatch<3, Scalar>& to, bool& good) {
    using Vector = std::conditional_t<std::is_same_v<Scalar, float>, typename Simd::Floats,
                                      typename Simd::Doubles>;
    using Masks = decltype(Vector{} == Vector{});
    constexpr int kLanes = sizeof(Vector) / sizeof(Scalar);
    constexpr auto kEachLane = std::make_index_sequence<kLanes>();
    /// Points come from memory, and processors do not fetch ahead across pages
    /// [bytes].
    constexpr std::size_t kAhead = 4096;
    Vector low[3], high[3];
    Masks numbers = Masks{} - 1;
    for (int a = 0; a < 3; ++a) {
        low[a] = Vector{} + std::numeric_limits<Scalar>::max();
        high[a] = Vector{} + std::numeric_limits<Scalar>::lowest();
    }
    std::size_t i = 0;
    for (; i + kLanes <= count; i += kLanes) {
        for (std::size_t at = 0; at < 3 * sizeof(Vector); at += 64)
            __builtin_prefetch(reinterpret_cast<const char*>(points + 3 * i) + kAhead + at, 0,
                               0);
        const Scalar* const from = points + 3 * i;
        const auto v0 = loaded<Vector>(from), v1 = loaded<Vector>(from + kLanes),
                   v2 = loaded<Vector>(from + 2 * kLanes);
        storeAxis(pickAxis<0>(v0, v1, v2, kEachLane), low[0], high[0], numbers,
                  to.coordinates[0] + i);
        storeAxis(pickAxis<1>(v0, v1, v2, kEachLane), low[1], high[1], numbers,
                  to.coordinates[1] + i);
        storeAxis(pickAxis<2>(v0, v1, v2, kEachLane), low[2], high[2], numbers,
                  to.coordinates[2] + i);
    }
    if (i == 0) return 0;
    for (int lane = 0; lane < kLanes; ++lane) {
        good &= numbers[lane] != 0;
        for (int a = 0; a < 3; ++a) {
            to.lowest[a] = std::min(to.lowest[a], double{low[a][lane]});
            to.highest[a] = std::max(to.highest[a], double{high[a][lane]});
        }
    }
    return i;
}

/// As CopyPoints.
template <typename Simd, int Dim, typename Scalar>
bool copyPoints(const Scalar* points, std::size_t count, double inverse,
                PointBatch<Dim, Scalar>& to) {
    bool good = true;
    std::size_t done = 0;
    if constexpr (Dim == 3) done = copyVectors<Simd>(points, count, to, good);
    good &= copySomePoints<Dim>(points, done, count, to);
    // Scaling is monotone, so the bounds stand for all points.
    for (int a = 0; a < Dim; ++a)
        good &= to.lowest[a] * inverse >= -double{kCellLimit} &&
                to.highest[a] * inverse < double{kCellLimit};
    return good;
}

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
