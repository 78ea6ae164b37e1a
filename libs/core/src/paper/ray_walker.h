// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The walk of one ray after the other, as in the seed paper.

#include <superray/core/culling_region.h>
#include <superray/core/ray_bundle.h>

#include "kernels/walk_kernel.h"
#include "tuning.h"

namespace superray {

/// Counts free cells of rays outside the culling region, for one thread.
template <int Dim>
class RayWalker {
 public:
    /// \param region may be empty
    RayWalker(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays,
              const CullingRegion<Dim>& region)
        : counts_(counts), rays_(rays), region_(region) {
        static const WalkKernel<Dim> best = bestKernels<Dim>().walk,
                                     portable = portableKernels<Dim>().walk;
        kernel_ = counts.directory.dense() ? best : portable;
    }
    RayWalker(const RayWalker&) = delete;
    RayWalker& operator=(const RayWalker&) = delete;
    ~RayWalker() { counts_.flush(weight_); }

    /// Counts the free cells of a ray outside the region, `weight` times.
    void walk(std::size_t ray, std::uint32_t weight) {
        const RayLine<Dim> line(rays_.geometry(), rays_.origin(ray), rays_.end(ray));
        std::int32_t from = 0;
        if (!region_.empty() && line.startCell() == region_.sensor()) {
            from = firstSlice_ = region_.firstSliceToWalk(line, firstSlice_);
            culled_ += from > 0;
        }
        if (weight != weight_ || counts_.addresses.size() >= CountingCosts::kFlushAt) {
            counts_.flush(weight_);
            weight_ = weight;
        }
        counts_.addresses.reserveMore(static_cast<std::size_t>(line.steps()));
        kernel_(counts_, line, from);
    }

    /// Rays that begin inside the region, so that a part of their walk was skipped.
    std::uint64_t culled() const { return culled_; }

 private:
    ScanCounts<Dim>& counts_;
    const RayBundle<Dim>& rays_;
    const CullingRegion<Dim>& region_;
    WalkKernel<Dim> kernel_;
    std::uint32_t weight_ = 1;
    std::int32_t firstSlice_ = 0;  // of the last ray: a good guess for the next
    std::uint64_t culled_ = 0;
};

}  // namespace superray
