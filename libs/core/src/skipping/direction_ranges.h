// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The ranges of a scan: for each bin of directions, how far rays get there, and
// from where on they have something to tell.

#include <superray/core/block.h>
#include <superray/core/ray_line.h>

#include "directions/classified_batch.h"
#include "directions/ranges_view.h"
#include "memory/scratch_array.h"
#include "threads/branch_choice.h"

#include <algorithm>
#include <vector>

namespace superray {

/// The farthest cells and the first slice of each bin. Both are kept in a pyramid, so that
/// something near, which covers many bins, is looked up or noted in a few coarse ones.
template <int Dim>
class DirectionRanges {
 public:
    using Slice = superray::Slice;
    static constexpr Slice kNever = kNoSlice;

    /// No rays yet. \param origin of the rays [units]
    void reset(const DirectionBins<Dim>& bins, const Units<Dim>& origin);

    /// Adds some of the rays of `directions`, and all sectors of them.
    void addRays(const ClassifiedBatch<Dim>& directions, const std::uint32_t* rays,
                 std::size_t count);
    /// Bins in which rays leave the sensor's cell.
    std::size_t binsWithRays() const { return binsWithRays_; }
    /// After the last ray, before the first question.
    void completeFarthest();

    /// Whether a ray may visit a cell of the block, and has nothing to tell before.
    bool sees(const BlockKey<Dim>& block) const;

    /// Forgets what was noted: no ray has anything to tell, or each from the
    /// beginning on.
    void clear();
    void markAll();
    /// Notes that rays have something to tell at these cells of a block.
    void markBoundary(const BlockKey<Dim>& block, const BlockMask<Dim>& cells);
    /// After the last open(), before the first question about it.
    void completeUnsettled();
    /// The first slice in which a ray of the sub-bin may have something to tell; kNever if
    /// none.
    Slice firstUnsettled(std::uint32_t subBin) const {
        const FirstUnsettled unsettled = unsettled_[DirectionBins<Dim>::binOf(subBin)];
        return unsettled.contains(subBin) ? unsettled.slice() : kNever;
    }
    /// Of all bins.
    const FirstUnsettled* unsettled() const { return unsettled_.data(); }

 private:
    template <typename Visit>
    void forEachSector(const BlockKey<Dim>& block, const Visit& visit) const;
    void fillUnsettled(FirstUnsettled unsettled);
    void updateVisibleEnds();
    template <typename Value, typename Join>
    void raise(Value* sector, const Join& join) const;
    template <Branches branches>
    std::size_t addInterleaved(const ClassifiedBatch<Dim>& directions,
                               const std::uint32_t* rays, std::size_t count);
    void use(std::uint32_t sectors);

    DirectionBins<Dim> bins_;
    std::uint32_t perSector_ = 0;
    std::size_t binsWithRays_ = 0;
    BranchChoice farthestGrows_;
    std::uint32_t used_ = 0;  // bit per sector
    Cell<Dim> sensor_{};
    float within_[Dim] = {};  // of the origin in its cell
    std::vector<std::uint32_t> levelBegin_;
    // Only sectors that are used are initialised.
    ScratchArray<CellOffset> farthest_;  // largest, axis by axis
    ScratchArray<FirstUnsettled> unsettled_;
    /// The farthest slice that rays reach and that is not behind boundary cells in all
    /// sub-bins,
    /// + 1.
    ScratchArray<Slice> visibleEnd_;
    std::uint32_t marked_ = 0;  // bins since the limits were computed
};

}  // namespace superray
