// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The walks of a scan, spread over threads.

#include <superray/core/culling_region.h>
#include <superray/core/super_rays.h>

#include "counting/scan_hits.h"
#include "directions/scan_bounds.h"
#include "directions/sector_sort.h"
#include "paper/end_cells.h"
#include "skipping/skipping_walk.h"
#include "threads/backoff.h"
#include "threads/load_balancer.h"

#include <vector>

namespace superray {

/// Counts the misses and hits of one scan after the other, in as many threads as are allowed.
///
/// Each thread has a worker that counts for itself. Counts saturate, and saturating sums do
/// not depend on order, so neither does the total on how the rays were spread.
template <int Dim>
class ScanWalk {
 public:
    /// Rays that were walked in part only, or left out.
    struct Result {
        const ScanCounts<Dim>& counts;  ///< valid until the next call
        std::uint64_t culled;
    };

    /// Walks super rays, each from where it leaves the region (which may be empty).
    Result walkSuperRays(const RayBundle<Dim>& rays, const ScanBounds<Dim>& bounds,
                         unsigned threads, const std::vector<SuperRay>& superRays,
                         const CullingRegion<Dim>& region);

    /// Walks every ray, from where it leaves the region (which may be empty). A ray whose end
    /// cell the region encloses needs no walk.
    Result walkEach(const RayBundle<Dim>& rays, const ScanBounds<Dim>& bounds, unsigned threads,
                    const CullingRegion<Dim>& region);

    /// Walks every ray from where it may change the map; see SkippingWalk.
    /// \param map nullptr: none
    /// \pre the rays have a common origin
    Result walkSkipping(const RayBundle<Dim>& rays, const ScanBounds<Dim>& bounds,
                        unsigned threads, const SaturationSource<Dim>* map,
                        const SaturationLimits& limits);

    /// Pre-faults about `bytes` of memory for the counts of scans to come. Ends the last scan.
    void reserve(std::size_t bytes, unsigned threads);

 private:
    /// What one thread keeps from scan to scan.
    struct Worker {
        ScanCounts<Dim> counts;
        EndCells<Dim> ends;
        SkippingWalk<Dim> skipping;
        HitBlocks<Dim> hitBlocks;  // where hits of all threads matter to each
        std::uint64_t culled = 0;
    };

    void start(std::size_t rays, unsigned threads);
    void countEndCells(const RayBundle<Dim>& rays, const ScanBounds<Dim>& bounds);
    Sampling sampling();
    void learn(const std::vector<ChunkReport>& reports);
    void shareHits(SkippingScan<Dim>& scan);
    Result sum();

    std::vector<Worker> workers_{1};
    std::size_t used_ = 1;  // workers of this scan
    SectorSort<Dim> sort_;
    Backoff samplePays_;
    LoadBalancer balancer_;  // of walkSkipping()
    ScanHits<Dim> hitsOfAll_;
};

}  // namespace superray
