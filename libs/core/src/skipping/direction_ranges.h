// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Per direction bin: the farthest end cell, and the first slice that may still change the map.

#include <superray/core/block.h>
#include <superray/core/ray_line.h>

#include "directions/classified_batch.h"
#include "directions/ranges_view.h"
#include "memory/scratch_array.h"
#include "threads/branch_choice.h"

#include <vector>

namespace superray {

/// What is known of all rays of a chunk, direction by direction.
///
/// Both values are kept in a pyramid of bins, like a mip map: something near covers many fine
/// bins, and is looked up or marked in a few coarse ones.
///
/// A Builder makes the ranges. They are constant from then on, but for one thing, which a
/// Marker does: boundary cells mark the sub-bins of rays that may pass them.
template <int Dim>
class DirectionRanges {
 public:
    class Builder;
    class Marker;

    static constexpr Slice kNever = kNoSlice;

    /// Bins in which rays leave the sensor's cell.
    std::size_t binsWithRays() const { return binsWithRays_; }

    /// Whether a ray may visit a cell of the block, and may do so before it passes marked
    /// cells: after them it is walked anyway.
    bool sees(const BlockKey<Dim>& block) const;

    /// The first slice in which a ray of the sub-bin may change the map; kNever if in none.
    Slice firstUnsettled(std::uint32_t subBin) const {
        const FirstUnsettled unsettled = unsettled_[DirectionBins<Dim>::binOf(subBin)];
        return unsettled.contains(subBin) ? unsettled.slice() : kNever;
    }
    /// The marks of all bins, for kernels.
    const FirstUnsettled* unsettled() const { return unsettled_.data(); }

 private:
    void reset(const DirectionBins<Dim>& bins, const Units<Dim>& origin);
    void clearSectors(std::uint32_t sectors);
    template <Branches branches>
    std::size_t addInterleaved(const ClassifiedBatch<Dim>& batch, const std::uint32_t* rays,
                               std::size_t count);
    void completeFarthest();
    void fillUnsettled(FirstUnsettled unsettled);
    void updateVisibleEnds();
    void completeUnsettled();
    static void spreadMarks(const FirstUnsettled* coarse, FirstUnsettled* fine,
                            std::uint32_t edge);
    void mark(const BlockKey<Dim>& block, const BlockMask<Dim>& cells);
    template <typename Visit>
    void forEachSector(const BlockKey<Dim>& block, const Visit& visit) const;
    template <typename Value, typename Join>
    void buildPyramid(Value* sector, const Join& join) const;

    DirectionBins<Dim> bins_;
    std::uint32_t perSector_ = 0;  // bins
    std::size_t binsWithRays_ = 0;
    BranchChoice farthestGrows_;
    std::uint32_t used_ = 0;  // bit per sector: there are rays, so the arrays are set
    Cell<Dim> sensor_{};
    float within_[Dim] = {};  // position of the origin in its cell, 0 .. 1
    std::vector<std::uint32_t> levelBegin_;
    ScratchArray<CellOffset> farthest_;  // greatest offset of end cells, axis by axis
    ScratchArray<FirstUnsettled> unsettled_;
    /// One more than the farthest slice of a ray that is not behind marked cells; less than
    /// the length of the rays only where all sub-bins are marked.
    ScratchArray<Slice> visibleEnd_;
    std::uint32_t marked_ = 0;  // bins, since the visible ends were computed
};

/// Builds the ranges of a chunk, which are complete when the builder goes out of scope.
template <int Dim>
class DirectionRanges<Dim>::Builder {
 public:
    /// \param origin of the rays [units]
    Builder(DirectionRanges& ranges, const DirectionBins<Dim>& bins, const Units<Dim>& origin)
        : ranges_(ranges) {
        ranges_.reset(bins, origin);
    }
    ~Builder() { ranges_.completeFarthest(); }
    Builder(const Builder&) = delete;
    Builder& operator=(const Builder&) = delete;

    /// Adds `count` rays of a batch, one for each run of rays that end in the same cell.
    void add(const ClassifiedBatch<Dim>& batch, const std::uint32_t* rays, std::size_t count);

 private:
    DirectionRanges& ranges_;
};

/// Marks boundary cells in the ranges, beginning with none marked. The marks are complete
/// when the marker goes out of scope.
template <int Dim>
class DirectionRanges<Dim>::Marker {
 public:
    explicit Marker(DirectionRanges& ranges) : ranges_(ranges) {
        ranges_.fillUnsettled(FirstUnsettled::never());
        ranges_.updateVisibleEnds();
    }
    ~Marker() {
        if (!all_) ranges_.completeUnsettled();
    }
    Marker(const Marker&) = delete;
    Marker& operator=(const Marker&) = delete;

    /// Marks these cells of a block in the sub-bins of all rays that may pass them.
    void mark(const BlockKey<Dim>& block, const BlockMask<Dim>& cells) {
        ranges_.mark(block, cells);
    }
    /// Marks every sub-bin from slice 0 on. Nothing else may be marked.
    void markAll() {
        all_ = true;
        ranges_.fillUnsettled(FirstUnsettled::all(0));
    }
    /// What sees() tells takes account of marks so far, as far as these were complete.
    const DirectionRanges& ranges() const { return ranges_; }

 private:
    DirectionRanges& ranges_;
    bool all_ = false;
};

}  // namespace superray
