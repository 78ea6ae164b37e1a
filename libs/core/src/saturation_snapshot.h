#pragma once
// Saturation as seen from inside a scan: cells that the map has at the lower
// clamp, or that this scan has missed often enough to take them there. Misses
// more change nothing in either.

#include <superray/core/scan_integrator.h>

#include "walk_kernel.h"

#include <vector>

namespace superray {

/// Cells of a block with at least `threshold` misses (1 .. 255).
template <int Dim>
BlockMask<Dim> cellsWithMisses(const std::uint8_t* misses, std::uint32_t threshold);

/// A copy: reading it needs no care while threads go on counting.
template <int Dim>
class SaturationSnapshot {
 public:
    /// Extents of more blocks than this are not copied (the copy stays empty,
    /// which is allowed: less is known, all of it true).
    static constexpr std::uint64_t kLargest = std::uint64_t{1} << 20;

    /// Copies what the map knows of the blocks in `box`.
    /// \param map may be nullptr
    void assign(const BlockBox<Dim>& box, const SaturationSource<Dim>* map, float lowerClamp);

    /// Adds the cells with at least `threshold` misses.
    void add(const WalkState<Dim>& counted, std::uint32_t threshold);

    const BlockMask<Dim>* mask(const BlockKey<Dim>& key) const {
        const std::uint32_t n = directory_.number(key);
        return n == 0 ? nullptr : &masks_[n - 1];
    }

 private:
    BlockMask<Dim>& makeMask(const BlockKey<Dim>& key);

    BlockDirectory<Dim> directory_;  // block -> 1 + index into masks
    std::vector<BlockMask<Dim>> masks_;
};

}  // namespace superray
