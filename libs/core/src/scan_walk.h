#pragma once
// The walks of a scan, shared out to threads. Each share counts for itself;
// saturating sums make the total independent of how rays were shared out.

#include <superray/core/culling_region.h>
#include <superray/core/super_rays.h>

#include "end_cells.h"
#include "ray_walker.h"
#include "scan_extent.h"

#include <vector>

namespace superray {

template <int Dim>
class ScanWalk {
 public:
    /// Begins a scan: shares out the rays and counts their end cells.
    /// \param rays must live until finish()
    void begin(const RayBundle<Dim>& rays, const ScanExtent<Dim>& extent, unsigned threads);

    /// Distinct end cells (of each share, added up).
    std::size_t endCells() const;

    // One of these walks the rays:

    /// Super rays, each cut at the region (which may be empty).
    void walkSuperRays(const std::vector<SuperRay>& superRays,
                       const CullingRegion<Dim>& region);

    /// Every ray on its own, cut at the region; not those whose end cell the
    /// region encloses.
    void walkEach(const CullingRegion<Dim>& region);

    /// For scans with many rays per end cell and one origin. Rays to an end
    /// cell are walked a few at a time, and only in the slices in which their
    /// frustum still has unsaturated cells: after the first few, none has.
    /// \param enough misses after which more change nothing
    void walkDense(const SaturationSource<Dim>* map, float lowerClamp, std::uint32_t enough);

    /// Adds the hits, and all shares into one. Valid until the next begin().
    const WalkState<Dim>& finish();

    std::uint64_t culled() const;

 private:
    /// One thread's part of a scan.
    struct Share {
        WalkState<Dim> state;
        EndCells<Dim> ends;
        std::vector<RayLine<Dim>> lines;
        std::uint64_t culled = 0;
    };

    template <typename Work>
    void inParallel(const Work& work);
    std::size_t firstRay(std::size_t share, std::size_t rays) const {
        return rays * share / shareCount_;
    }
    void walkGroup(RayWalker<Dim>& walker, Share& share, const std::uint32_t* begin,
                   const std::uint32_t* end, std::uint32_t enough) const;

    const RayBundle<Dim>* rays_ = nullptr;
    std::vector<Share> shares_{1};
    std::size_t shareCount_ = 1;
};

}  // namespace superray
