// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the stages of empty-space skipping pass to each other; see skipping_walk.h.

#include <superray/core/ray_bundle.h>
#include <superray/core/saturation_source.h>

#include "counting/saturation_limits.h"
#include "counting/scan_hits.h"
#include "kernels/walk_kernel.h"
#include "skipping/classified_rays.h"
#include "skipping/direction_ranges.h"
#include "threads/work_queue.h"

namespace superray {

/// Whether some rays of a chunk may be walked before the others.
enum class Sampling { never, whereItMayPay };

/// A scan and its map, the same for all threads. Everything referred to outlives the walk.
template <int Dim>
struct SkippingScan {
    const RayBundle<Dim>& rays;        ///< with a common origin
    const SaturationSource<Dim>* map;  ///< nullptr: none
    /// Hits of all threads, once all have classified their rays; nullptr: there is but one
    /// thread, or the hits of others do not matter.
    const ScanHits<Dim>* hitsOfAll = nullptr;
    SaturationLimits limits;
    Sampling sampling;
    Units<Dim> origin;     ///< of the rays
    Cell<Dim> sensorCell;  ///< of the origin

    SkippingScan(const RayBundle<Dim>& bundle, const SaturationSource<Dim>* source,
                 const SaturationLimits& saturation, Sampling samples)
        : rays(bundle),
          map(source),
          limits(saturation),
          sampling(samples),
          origin(RayLine<Dim>::unitsOf(bundle.geometry(), bundle.commonOrigin())),
          sensorCell(bundle.geometry().cellOf(bundle.commonOrigin())) {}
};

/// The vector kernels, or the portable ones, which alone serve a sparse directory.
template <int Dim>
const WalkKernels<Dim>& kernelsFor(const BlockDirectory<Dim>& directory) {
    static const WalkKernels<Dim> best = bestKernels<Dim>(), portable = portableKernels<Dim>();
    return directory.dense() ? best : portable;
}

/// Chosen rays of a chunk and what a walk must know of them. Constant once pieces of it can
/// be taken, so any thread may walk a piece.
template <int Dim>
struct WalkJob {
    std::size_t first = 0;                      ///< ray of the scan that the chunk begins with
    const ClassifiedRays<Dim>* rays = nullptr;  ///< of the chunk
    const DirectionRanges<Dim>* ranges = nullptr;  ///< where each of them starts to matter
    const std::uint32_t* chosen = nullptr;         ///< rays of the chunk, in order
};

/// A job and the pieces of it that nobody has taken yet.
template <int Dim>
struct SharedJob {
    WorkQueue queue;
    WalkJob<Dim> job;
};

}  // namespace superray
