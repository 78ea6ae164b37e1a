// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The settled cells around the sensor, and their boundary.

#include <superray/core/saturation_source.h>

#include "counting/saturation_limits.h"
#include "counting/scan_hits.h"
#include "skipping/direction_ranges.h"

#include <vector>

namespace superray {

/// What growing the region came to. The boundary cells themselves are in the ranges.
struct Boundary {
    bool sensorCellSettled = false;  ///< if not, every ray matters from its first slice on
    std::uint64_t work = 0;          ///< of growing [visits], see SkippingCosts
};

/// All settled cells that are connected with the sensor's cell by faces.
///
/// A cell is settled if another miss cannot change it in this scan: the map is saturated free
/// there, or the scan has missed it often enough, or has hit it so often that misses do not
/// matter. (Policy netEvidence: saturated free and not hit, or missed often enough beside its
/// hits.) A boundary cell is one that is not settled and shares a face with the region.
///
/// Why this is enough: the cells of a ray, in order, share faces. Those before its first cell
/// that is not settled are settled, the first of them is the sensor's cell, so all of them
/// are in the region, and that first cell is a boundary cell. So no ray can change the map
/// before it meets a boundary cell.
///
///     sensor . . . . . # x x x        .  settled, in the region   #  boundary cell
///            . . . # # x x x x        x  anything: not looked at
template <int Dim>
class SettledRegion {
 public:
    /// Forgets the last scan.
    /// \param box blocks of the scan
    /// \param map nullptr: none; must outlive the scan
    /// \param hitsOfAll as in SkippingScan
    void reset(const BlockBox<Dim>& box, const SaturationSource<Dim>* map,
               const SaturationLimits& limits, const ScanHits<Dim>* hitsOfAll);

    /// Grows the region anew from the sensor's cell, block by block, nearest first, and marks
    /// the boundary cells that rays reach in the ranges. Marks of an earlier call are dropped.
    /// \param counts misses and hits of the scan so far
    /// \param mostWork where about so much work [visits] is done, the region ends: the cells
    ///        beside it are marked, settled or not
    Boundary grow(const Cell<Dim>& sensor, const ScanCounts<Dim>& counts,
                  DirectionRanges<Dim>& ranges, std::uint64_t mostWork);

 private:
    using Marker = typename DirectionRanges<Dim>::Marker;

    struct Block {
        BlockKey<Dim> key;
        BlockMask<Dim> settled, reached, boundary;
        BlockMask<Dim> marked;     // of the boundary
        std::uint32_t growth = 0;  // the last one that came here
        bool queued = false, relevant = false;
        bool knowsMap = false;  // whether the next member is set
        BlockSaturation<Dim> inMap;
    };

    std::uint32_t blockAt(const BlockKey<Dim>& key);
    bool enter(Block& block);
    void findSettled(Block& block);
    void unsettleHits(Block& block, const std::uint8_t* misses, const std::uint8_t* hits) const;
    void spread(std::uint32_t id);
    void pass(const BlockKey<Dim>& to, const BlockMask<Dim>& cells);
    void mark(Block& block);

    BlockDirectory<Dim> directory_;  // block -> 1 + id
    std::vector<Block> blocks_;      // by id
    std::vector<std::uint32_t> queue_, visited_;
    SaturationLimits limits_;
    const SaturationSource<Dim>* map_ = nullptr;
    const ScanHits<Dim>* hitsOfAll_ = nullptr;

    // Of the grow() that runs, or ran last.
    std::uint32_t growth_ = 0;
    std::uint64_t work_ = 0, mostWork_ = 0;
    const ScanCounts<Dim>* counts_ = nullptr;
    Marker* marker_ = nullptr;
};

}  // namespace superray
