#pragma once
// The walks of a scan, shared out to threads. Each share counts for itself;
// saturating sums make the total independent of how rays were shared out.

#include <superray/core/culling_region.h>
#include <superray/core/parallel.h>
#include <superray/core/super_rays.h>

#include "threads/attempts.h"
#include "paper/end_cells.h"
#include "skipping/horizon_walk.h"
#include "paper/ray_walker.h"
#include "directions/scan_extent.h"
#include "threads/share_balance.h"

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
    void begin(const RayBundle<Dim>& rays, const ScanExtent<Dim>& extent, unsigned threads);

    // One of these walks the rays:

    /// Super rays, each cut at the region (which may be empty).
    void walkSuperRays(const std::vector<SuperRay>& superRays,
                       const CullingRegion<Dim>& region);

    /// Every ray on its own, cut at the region; not those whose end cell the
    /// region encloses.
    void walkEach(const CullingRegion<Dim>& region);

    /// Every ray, from where it has something to tell; see HorizonWalk.
    /// \pre the rays have the common origin
    void walkFromHorizon(const SaturationSource<Dim>* map, const SensorModel& model,
                         UpdatePolicy policy);

    /// Adds all shares into one. Valid until the next begin().
    const WalkState<Dim>& finish();

    std::uint64_t culled() const;

    /// Has so many bytes at hand for the counts of a scan. Ends the last one.
    void reserve(std::size_t bytes, unsigned threads);

 private:
    /// Kinds of rays, and lone rays.
    static constexpr std::size_t kSortedKinds = DirectionTiles<Dim>::kKinds + 1;

    /// One thread's part of a scan.
    struct Share {
        WalkState<Dim> state;
        EndCells<Dim> ends;
        HorizonWalk<Dim> horizon;
        std::vector<std::uint8_t> kinds;               // of its rays, when they are sorted
        std::array<std::size_t, kSortedKinds> ofKind;  // how many; where the next one goes
        std::uint64_t culled = 0;
    };

    std::size_t firstRay(std::size_t share, std::size_t rays) const {
        return shareBegin(rays, share, shareCount_);
    }
    bool sortingRepays() const;
    void learn();
    void countEndCells();
    void sortByDirection();
    void findKinds(Share& share, std::size_t first, std::size_t last);

    const RayBundle<Dim>* rays_ = nullptr;
    BlockBox<Dim> blocks_;
    std::optional<RayBundle<Dim>> sorted_;  // the same rays, for several threads
    std::vector<Share> shares_{1};
    std::size_t shareCount_ = 1;
    Attempts sampleRepays_;
    ShareBalance balance_;  // of walkFromHorizon()
};

}  // namespace superray
