// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The lines of 8 rays of one sector, set up side by side, one per lane.

#include <superray/core/ray_bundle.h>
#include <superray/core/ray_line.h>

#include "kernels/simd/lanes.h"
#include "kernels/walk_kernel.h"

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

/// As RayLine, of each lane. The sector is common, and so are flips and first
/// cells.
template <typename Simd, int Dim>
struct LineLanes {
    using Long8 = typename Simd::Long8;
    Cell<Dim> flip, first;
    Long8 slope[Dim - 1], exit0[Dim - 1];  ///< per minor axis
    Ints last[Dim], lastSlice;
    int twice;  ///< bits of the lanes whose lines step twice in their last slice
};

/// Mirrored extent of the rays along one axis, in units, as RayLine computes
/// it: units = 2 * floor(end / resolution * 2^30) + 1; extent = +-(units -
/// origin)
template <typename Simd, int Dim>
SUPERRAY_INLINE typename Simd::Long8 extentOf(const RayBundle<Dim>& rays, const RayLanes& lanes,
                                              int a, std::int64_t origin, bool flipped) {
    const typename Simd::Double8 end =
        rays.singlePrecision() ? Simd::gatherDoubles(rays.template ends<float>(a), lanes.ray)
                               : Simd::gatherDoubles(rays.template ends<double>(a), lanes.ray);
    const typename Simd::Double8 scaled = Simd::times(end, rays.geometry().scaled(1.0));
    const typename Simd::Long8 half = Simd::floorOf(Simd::times(scaled, 1073741824.0));  // 2^30
    const typename Simd::Long8 to = half + half + Simd::all(1);
    const typename Simd::Long8 from = Simd::all(origin);
    return flipped ? from - to : to - from;
}

template <typename Simd, int Dim, int D>
SUPERRAY_INLINE LineLanes<Simd, Dim> setUp(const RayBundle<Dim>& rays, const RayLanes& lanes) {
    using Long8 = typename Simd::Long8;
    using Double8 = typename Simd::Double8;
    const Units<Dim> origin = RayLine<Dim>::unitsOf(rays.geometry(), rays.commonOrigin());
    LineLanes<Simd, Dim> lines;
    Units<Dim> start;
    Long8 extent[Dim];
    for (int a = 0; a < Dim; ++a) {
        lines.flip[a] = -static_cast<std::int32_t>(lanes.sector >> (2 + a) & 1);
        start[a] = lines.flip[a] ? -origin[a] : origin[a];
        lines.first[a] = RayLine<Dim>::cellOfUnits(start[a]);
        extent[a] = extentOf<Simd>(rays, lanes, a, origin[a], lines.flip[a] != 0);
        lines.last[a] = Simd::cells(Simd::all(start[a]) + extent[a]);
    }
    // The sector is certain, so the major extent is the largest.
    const std::int64_t toBorder = (std::int64_t{lines.first[D]} + 1) * kUnitsPerCell - start[D];
    const Double8 length = Simd::toDouble(extent[D]);
    lines.lastSlice = lines.last[D] - lines.first[D];
    const Long8 exitsBefore = Simd::wide(lines.lastSlice - 1);
    Ints twice{};
    for (int m = 0; m < Dim - 1; ++m) {
        const int a = minorAxis<D>(m);
        // slope = floor(extent / length * 2^31); exit0 = start + (toBorder * slope
        // >> 31)
        const Double8 steepness = Simd::over(Simd::toDouble(extent[a]), length);
        const Long8 slope = Simd::floorOf(Simd::times(steepness, 2147483648.0));
        const Long8 exit0 =
            Simd::all(start[a]) + Simd::wholeUnits(Simd::product(Simd::all(toBorder), slope));
        // entered = cell(exit0 + (lastSlice - 1) * slope)
        const Ints entered = Simd::cells(exit0 + Simd::product(exitsBefore, slope));
        twice |= lines.last[a] - (lines.lastSlice == 0 ? Ints{} + lines.first[a] : entered) > 1;
        lines.slope[m] = slope;
        lines.exit0[m] = exit0;
    }
    lines.twice = Simd::bitsOf(twice);
    return lines;
}

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
