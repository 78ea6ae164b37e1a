// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// End cells of a chunk of a scan: how many rays end in each, and which rays may change more.

#include <superray/core/culling_region.h>
#include <superray/core/ray_bundle.h>

#include "kernels/walk_kernel.h"

#include <vector>

namespace superray {

/// End cells of rays [begin, end), block by block.
template <int Dim>
class EndCells {
 public:
    /// Counts the end cells of rays[begin, end). `box` holds all of them.
    void assign(const RayBundle<Dim>& rays, std::size_t begin, std::size_t end,
                const BlockBox<Dim>& box);

    /// Looks up which end cells are enclosed by the region.
    /// \pre the rays start in the cell region.sensor()
    void findEnclosed(const CullingRegion<Dim>& region);
    /// True if the ray can change nothing but its end cell.
    bool enclosed(std::size_t ray) const {
        const std::uint32_t a = addresses_[ray - first_];
        return enclosed_[a / kCells].test(static_cast<int>(a % kCells));
    }

    /// Adds the returns to the batch as hits.
    void addHits(ScanCounts<Dim>& counts) const;

 private:
    static constexpr std::uint32_t kCells = kBlockCells<Dim>;

    std::size_t first_ = 0;
    BlockDirectory<Dim> directory_;  // block -> 1 + id
    std::vector<BlockKey<Dim>> keys_;
    std::vector<std::uint32_t> addresses_;  // per ray: id * kCells + index
    std::vector<std::uint8_t> hits_;        // ... with a return; saturating
    std::vector<BlockMask<Dim>> enclosed_;  // per block
};

}  // namespace superray
