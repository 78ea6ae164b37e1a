// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The walks of a scan, shared out to threads. Each share counts for itself;
// saturating sums make the total independent of how rays were shared out.

#include <superray/core/culling_region.h>
#include <superray/core/detail/parallel.h>
#include <superray/core/super_rays.h>

#include "directions/scan_bounds.h"
#include "paper/end_cells.h"
#include "paper/ray_walker.h"
#include "skipping/skipping_walk.h"
#include "threads/backoff.h"
#include "threads/load_balancer.h"

#include <array>
#include <optional>
#include <utility>
#include <vector>

namespace superray {

template <int Dim>
class ScanWalk {
 public:
    /// Begins a scan: shares out the rays.
    /// \param rays must live until finish()
    void begin(const RayBundle<Dim>& rays, const ScanBounds<Dim>& bounds, unsigned threads);

    // One of these walks the rays:

    /// Super rays, each cut at the region (which may be empty).
    void walkSuperRays(const std::vector<SuperRay>& superRays,
                       const CullingRegion<Dim>& region);

    /// Every ray on its own, cut at the region; not those whose end cell the
    /// region encloses.
    void walkEach(const CullingRegion<Dim>& region);

    /// Every ray, from where it has something to tell; see SkippingWalk.
    /// \pre the rays have the common origin
    void walkSkipping(const SaturationSource<Dim>* map, const SensorModel& model,
                      UpdatePolicy policy);

    /// Adds all shares into one. Valid until the next begin().
    const ScanCounts<Dim>& finish();

    std::uint64_t culled() const;

    /// Has so many bytes at hand for the counts of a scan. Ends the last one.
    void reserve(std::size_t bytes, unsigned threads);

 private:
    /// Sectors of rays, and unclassified rays.
    static constexpr std::size_t kSortedSectors = DirectionBins<Dim>::kSectors + 1;

    /// One thread's part of a scan.
    struct Worker {
        ScanCounts<Dim> counts;
        EndCells<Dim> ends;
        SkippingWalk<Dim> walk;
        std::vector<std::uint8_t> sectors;                 // of its rays, when they are sorted
        std::array<std::size_t, kSortedSectors> ofSector;  // how many; where the next one goes
        std::uint64_t culled = 0;
    };

    std::size_t firstRay(std::size_t chunk, std::size_t rays) const {
        return chunkBegin(rays, chunk, chunkCount_);
    }
    bool sortingRepays() const;
    void learn();
    void countEndCells();
    void sortByDirection();
    void findSectors(Worker& worker, std::size_t first, std::size_t last);

    const RayBundle<Dim>* rays_ = nullptr;
    BlockBox<Dim> blocks_;
    std::optional<RayBundle<Dim>> sorted_;  // the same rays, for several threads
    std::vector<Worker> workers_{1};
    std::size_t chunkCount_ = 1;
    Backoff sampleRepays_;
    LoadBalancer balance_;  // of walkSkipping()
};

}  // namespace superray
