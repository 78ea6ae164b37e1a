// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/traversal.h>

#include "kernels/compiler.h"
#include "kernels/walk_kernel.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#define SUPERRAY_TARGET

namespace superray {
namespace {
namespace simd {

inline std::uint32_t markRow(FirstUnsettled* unsettled, const CellOffset* farthest,
                             CellOffset offset, std::int32_t slice, std::uint32_t columns,
                             std::uint32_t rows) {
    std::uint32_t changed = 0;
    for (; columns != 0; columns >>= 4, ++unsettled, ++farthest) {
        const FirstUnsettled now = unsettled->joined(
            FirstUnsettled::of(static_cast<Slice>(slice), (columns & 15) * rows));
        if (now.word == unsettled->word || !offset.within(*farthest)) continue;
        *unsettled = now;
        changed += now.subBins() == FirstUnsettled::kAllSubBins;
    }
    return changed;
}

}  // namespace simd
}  // namespace
}  // namespace superray

#include "kernels/mark_boundary.inc"
//
#include "kernels/classify_rays.inc"
//
#include "kernels/find_runs.inc"
//
#include "kernels/choose_rays.inc"
//
#define SUPERRAY_POINT_BYTES 16
#include "kernels/copy_points.inc"

namespace superray {

template <int Dim>
void walkPortable(ScanCounts<Dim>& counts, const RayLine<Dim>& line, std::int32_t from,
                  std::int32_t to) {
    BlockKey<Dim> current{};
    std::uint32_t base = 0;
    bool known = false;
    forEachFreeCell(line, from, to, [&](const Cell<Dim>& cell) {
        const BlockKey<Dim> key = blockOf<Dim>(cell);
        if (!known || key != current) {
            current = key;
            known = true;
            base = counts.offsetOf(key);
        }
        counts.addresses.push(base + static_cast<std::uint32_t>(indexInBlock<Dim>(cell)));
    });
}

template <int Dim>
void walkPortable(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays, std::size_t ray,
                  std::int32_t from) {
    const RayLine<Dim> line(rays.geometry(), rays.commonOrigin(), rays.end(ray));
    counts.addresses.reserveMore(static_cast<std::size_t>(line.steps()));
    walkPortable(counts, line, from, line.slices());
}

namespace {

template <int Dim>
void walkLine(ScanCounts<Dim>& counts, const RayLine<Dim>& line, std::int32_t from) {
    walkPortable(counts, line, from, line.slices());
}

template <int Dim>
void walkRays(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays, const RayLanes& lanes) {
    for (int i = 0; i < lanes.count; ++i)
        walkPortable(counts, rays, lanes.ray[i], lanes.from[i]);
}

template <int Dim>
BlockMask<Dim> atLeast(const std::uint8_t* counts, std::uint32_t least) {
    BlockMask<Dim> mask;
    for (int i = 0; i < kBlockCells<Dim>; ++i)
        if (counts[i] >= least) mask.set(i);
    return mask;
}

}  // namespace

template <int Dim>
WalkKernels<Dim> portableKernels() {
    return {walkLine<Dim>,          walkRays<Dim>,     walkRays<Dim>,
            classifyRays<Dim>,      findRuns<Dim>,     chooseRays,
            atLeast<Dim>,           markBoundary<Dim>, copyPoints<Dim, float>,
            copyPoints<Dim, double>};
}

template void walkPortable(ScanCounts<2>&, const RayLine<2>&, std::int32_t, std::int32_t);
template void walkPortable(ScanCounts<3>&, const RayLine<3>&, std::int32_t, std::int32_t);
template void walkPortable(ScanCounts<2>&, const RayBundle<2>&, std::size_t, std::int32_t);
template void walkPortable(ScanCounts<3>&, const RayBundle<3>&, std::size_t, std::int32_t);
template WalkKernels<2> portableKernels();
template WalkKernels<3> portableKernels();

}  // namespace superray
