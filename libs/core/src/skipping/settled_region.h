// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The settled region of a scan: what the culling region is to a map, seen from
// every direction.

#include <superray/core/saturation_source.h>
#include "counting/saturation_limits.h"
#include "kernels/walk_kernel.h"

#include "skipping/direction_ranges.h"

#include <memory>
#include <vector>

namespace superray {

/// A cell is settled if more misses change nothing: the map is saturated free
/// there, this scan has missed it often enough, or has hit it so often that its
/// misses do not matter. The region is all settled cells that are connected with
/// the sensor's cell by faces. Cells beside it are open.
///
/// The cells of a ray before its first boundary cell are settled, and each is beside
/// the next. So they are in the region, and that boundary cell is beside it: what rays
/// have to tell begins at the boundary cells beside the region, wherever they are.
template <int Dim>
class SettledRegion {
 public:
    /// Begins a scan.
    /// \param map nullptr: none; must outlive the scan
    void reset(const BlockBox<Dim>& box, const SaturationSource<Dim>* map,
               const SaturationLimits& limits);

    /// Finds the region, nearest blocks first, and notes in the ranges the open
    /// cells beside it that rays reach.
    /// \param mostWork where about so much work is done, the region ends: the cells
    ///        beside it are noted as if they were open
    void build(const Cell<Dim>& sensor, const ScanCounts<Dim>& counts,
               DirectionRanges<Dim>& ranges, std::uint64_t mostWork);

    /// Whether the last build() found the sensor's own cell open.
    bool empty() const { return visited_.empty() || !blocks_[visited_[0]].reached.any(); }

    /// Work of the last build(), about as many times as long as visiting a cell
    /// of a ray.
    std::uint64_t work() const { return work_; }

 private:
    struct Block {
        BlockKey<Dim> key;
        BlockMask<Dim> settled, reached, boundary;
        BlockMask<Dim> marked;    // of `open`, in the ranges
        std::uint32_t build = 0;  // the last one that came here
        bool queued = false, relevant = false;
        bool knowsMap = false;  // what of the map follows:
        BlockSaturation<Dim> inMap;
    };

    std::uint32_t blockAt(const BlockKey<Dim>& key);
    bool enter(Block& block);
    void findSettled(Block& block);
    void spread(std::uint32_t id);
    void pass(const BlockKey<Dim>& to, const BlockMask<Dim>& cells);
    void mark(Block& block);

    BlockDirectory<Dim> directory_;  // block -> 1 + number
    std::vector<Block> blocks_;
    std::vector<std::uint32_t> queue_, visited_;
    std::uint32_t build_ = 0;
    std::uint64_t work_ = 0, mostWork_ = 0;
    const ScanCounts<Dim>* counts_ = nullptr;
    SaturationLimits limits_;
    const SaturationSource<Dim>* map_ = nullptr;
    DirectionRanges<Dim>* ranges_ = nullptr;
};

}  // namespace superray
