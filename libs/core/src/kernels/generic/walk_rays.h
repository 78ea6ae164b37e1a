// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Rays of one sector, whose lines are set up side by side and walked one by
// one.

#include "kernels/generic/line_lanes.h"
#include "kernels/generic/walk_line.h"

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

template <typename Simd, int Dim, int D>
void walkRaysAlong(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays, const RayLanes& lanes) {
    constexpr int kMinors = Dim - 1;
    const LineLanes<Simd, Dim> lines = setUp<Simd, Dim, D>(rays, lanes);
    alignas(64) std::int64_t slopes[kMinors][8], exits[kMinors][8];
    alignas(32) std::int32_t ends[Dim][8];
    for (int m = 0; m < kMinors; ++m) {
        Simd::store(lines.slope[m], slopes[m]);
        Simd::store(lines.exit0[m], exits[m]);
    }
    for (int a = 0; a < Dim; ++a) std::memcpy(ends[a], &lines.last[a], sizeof ends[a]);

    RayLine<Dim> line;
    line.major = D;
    line.flip = lines.flip;
    line.first = lines.first;
    for (int i = 0; i < lanes.count; ++i) {
        for (int a = 0; a < Dim; ++a) line.last[a] = ends[a][i];
        const std::int32_t from = lanes.from[i];
        if (from >= line.slices()) continue;
        if (lines.twice >> i & 1) {
            walkPortable(counts, rays, lanes.ray[i], from);
            continue;
        }
        for (int m = 0; m < kMinors; ++m) {
            const int a = minorAxis<D>(m);
            line.slope[a] = slopes[m][i];
            line.exit0[a] = exits[m][i];
        }
        counts.addresses.reserveMore(static_cast<std::size_t>(line.steps()));
        LineWalk<Simd, Dim, D>(counts, line, from).run();
    }
}

/// As WalkRays.
template <typename Simd, int Dim>
void walkRays(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays, const RayLanes& lanes) {
    if constexpr (!Simd::kWalksLanes) {
        for (int i = 0; i < lanes.count; ++i)
            walkPortable(counts, rays, lanes.ray[i], lanes.from[i]);
    } else {
        switch (lanes.sector & 3) {
            case 0:
                return walkRaysAlong<Simd, Dim, 0>(counts, rays, lanes);
            case 1:
                return walkRaysAlong<Simd, Dim, 1>(counts, rays, lanes);
            default:
                return walkRaysAlong<Simd, Dim, Dim - 1>(counts, rays, lanes);
        }
    }
}

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
