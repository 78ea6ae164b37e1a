// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Ray walks into an update batch: one kernel per instruction set, equal cells.

#include <superray/core/block.h>
#include <superray/core/ray_bundle.h>
#include <superray/core/ray_line.h>

#include "counting/scan_counts.h"
#include "directions/classified_batch.h"
#include "directions/ranges_view.h"
#include "kernels/point_kernels.h"

namespace superray {

/// Appends the free cells of a ray from slice `from` on.
/// \pre state.addresses.reserveMore(line.steps()) was called
template <int Dim>
using WalkKernel = void (*)(ScanCounts<Dim>& counts, const RayLine<Dim>& line,
                            std::int32_t from);

/// Up to 8 rays of one sector (ClassifiedBatch) from the common origin.
struct RayLanes {
    std::uint32_t sector = 0;
    int count = 0;
    alignas(32) std::uint32_t ray[8] = {};  ///< numbers; of unused lanes: any
    alignas(32) std::int32_t from[8] = {};  ///< slices to begin with
};

/// Appends the free cells of some rays. \pre count > 0
template <int Dim>
using WalkRays = void (*)(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays,
                          const RayLanes& lanes);

/// Which of the counts of a block are at least `least`, 1 <= least <= 255.
template <int Dim>
using AtLeast = BlockMask<Dim> (*)(const std::uint8_t* counts, std::uint32_t least);

/// What exists per instruction set.
template <int Dim>
struct WalkKernels {
    WalkKernel<Dim> walk;
    WalkRays<Dim> walkRays;
    WalkRays<Dim> walkEnds;  ///< the same, faster for few slices. \pre all from > 0
    ClassifyRays<Dim> classifyRays;
    FindRuns<Dim> findRuns;
    ChooseRays chooseRays;
    AtLeast<Dim> atLeast;
    MarkBoundary<Dim> markBoundary;
    CopyPoints<Dim, float> copyFloats;
    CopyPoints<Dim, double> copyDoubles;

    CopyPoints<Dim, float> copy(float) const { return copyFloats; }
    CopyPoints<Dim, double> copy(double) const { return copyDoubles; }
};

/// The free cells in the slices [from, to), for any instruction set.
template <int Dim>
void walkPortable(ScanCounts<Dim>& counts, const RayLine<Dim>& line, std::int32_t from,
                  std::int32_t to);
/// Those of a ray of the common origin, from slice `from` on.
template <int Dim>
void walkPortable(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays, std::size_t ray,
                  std::int32_t from);
/// The portable kernels also serve directories that are not dense.
template <int Dim>
WalkKernels<Dim> portableKernels();

/// 8 slices (rays) at once; walks need a dense directory.
/// \pre the processor has the instruction set, see bestInstructionSet()
template <int Dim>
WalkKernels<Dim> avx2Kernels();
template <int Dim>
WalkKernels<Dim> avx512Kernels();

/// The kernels for instructionSet() (detail/cpu_target.h): the fastest ones of this
/// processor, unless the user asks for lesser ones.
template <int Dim>
WalkKernels<Dim> bestKernels();

}  // namespace superray
