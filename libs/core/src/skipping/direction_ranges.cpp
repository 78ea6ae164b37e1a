// SPDX-License-Identifier: BSD-3-Clause
#include "skipping/direction_ranges.h"

#include "kernels/walk_kernel.h"
#include "threads/interleave.h"
#include "tuning.h"

#include <algorithm>

namespace superray {
namespace {

/// Spreads the sub-bins of a coarse bin that cover its quarter (x, y) over the 16 sub-bins of
/// the fine bin there: each becomes a square of four.
std::uint32_t subBinsBelow(std::uint32_t subBins, std::uint32_t x, std::uint32_t y) {
    const std::uint32_t s = subBins >> (2 * x + 8 * y);
    const std::uint32_t rows = 3 * (s & 0x11) | 6 * (s & 0x22);  // columns twice
    return 0x11 * (rows & 0x0F) | 0x110 * (rows & 0xF0);
}

/// Calls visit(id) for each sector of a set, bit by bit.
template <typename Visit>
void forEachSectorOf(std::uint32_t sectors, const Visit& visit) {
    for (std::uint32_t left = sectors; left != 0; left &= left - 1)
        visit(static_cast<std::uint32_t>(__builtin_ctz(left)));
}

}  // namespace

/// Begins with no rays. Arrays are set sector by sector, when rays come.
template <int Dim>
void DirectionRanges<Dim>::reset(const DirectionBins<Dim>& bins, const Units<Dim>& origin) {
    bins_ = bins;
    perSector_ = bins.perSector();
    used_ = 0;
    binsWithRays_ = 0;
    levelBegin_.clear();
    for (int l = 0; l <= bins.levels; ++l) levelBegin_.push_back(bins.levelBegin(l));
    farthest_.reserve(bins.count() + RangesView<Dim>::kSlack);
    unsettled_.reserve(bins.count() + RangesView<Dim>::kSlack);
    visibleEnd_.reserve(bins.count());
    farthest_[bins.unclassified()] = CellOffset{};
    for (int a = 0; a < Dim; ++a) {
        sensor_[a] = RayLine<Dim>::cellOfUnits(origin[a]);
        within_[a] = static_cast<float>(origin[a] & (kUnitsPerCell - 1)) /
                     static_cast<float>(kUnitsPerCell);
    }
}

template <int Dim>
void DirectionRanges<Dim>::clearSectors(std::uint32_t sectors) {
    forEachSectorOf(sectors & ~used_, [&](std::uint32_t sector) {
        std::fill_n(farthest_.data() + perSector_ * sector, perSector_, CellOffset{});
    });
    used_ |= sectors;
}

template <int Dim>
void DirectionRanges<Dim>::Builder::add(const ClassifiedBatch<Dim>& batch,
                                        const std::uint32_t* rays, std::size_t count) {
    ranges_.clearSectors(batch.sectors);
    BranchChoice& grows = ranges_.farthestGrows_;
    grows.learn(grows.unpredictable()
                    ? ranges_.template addInterleaved<Branches::none>(batch, rays, count)
                    : ranges_.template addInterleaved<Branches::predicted>(batch, rays, count),
                count);
}

/// Extends the farthest ends of bins by those of rays. Interleaved, since neighbouring rays
/// often go into the same bin, and each would wait for the store of the one before.
/// \return how many rays extended something
template <int Dim>
template <Branches branches>
std::size_t DirectionRanges<Dim>::addInterleaved(const ClassifiedBatch<Dim>& batch,
                                                 const std::uint32_t* rays, std::size_t count) {
    std::size_t changes = 0;
    interleave(count, [&](std::size_t, std::size_t i) {
        const CellOffset end = batch.endOffset[rays[i]];
        // That of the unclassified bin is not used.
        CellOffset& farthest = farthest_[DirectionBins<Dim>::binOf(batch.subBin[rays[i]])];
        const bool change = !end.within(farthest);
        changes += change;
        if (branches == Branches::none || change) farthest = farthest.joined(end);
    });
    return changes;
}

/// Fills in the coarser levels, and counts the bins that have rays.
template <int Dim>
void DirectionRanges<Dim>::completeFarthest() {
    forEachSectorOf(used_, [&](std::uint32_t sector) {
        CellOffset* const bins = farthest_.data() + perSector_ * sector;
        for (std::uint32_t b = 0; b < levelBegin_.data()[1]; ++b)
            binsWithRays_ += bins[b] != CellOffset();
        buildPyramid(bins, [](CellOffset x, CellOffset y) { return x.joined(y); });
    });
}

/// Fills in the coarser levels of a sector: each bin joins the four (in 2D, two) bins below.
template <int Dim>
template <typename Value, typename Join>
void DirectionRanges<Dim>::buildPyramid(Value* sector, const Join& join) const {
    for (int level = 1; level <= bins_.levels; ++level) {
        const Value* fine = sector + levelBegin_[static_cast<std::size_t>(level - 1)];
        Value* coarse = sector + levelBegin_[static_cast<std::size_t>(level)];
        const std::uint32_t edge = bins_.edge(level);
        for (std::uint32_t y = 0; y < (Dim == 3 ? edge : 1); ++y) {
            for (std::uint32_t x = 0; x < edge; ++x) {
                coarse[x] = join(fine[2 * x], fine[2 * x + 1]);
                if (Dim == 3)
                    coarse[x] = join(coarse[x],
                                     join(fine[2 * edge + 2 * x], fine[2 * edge + 2 * x + 1]));
            }
            coarse += edge;
            fine += 4 * edge;
        }
    }
}

/// Sets the marks of all bins. Unclassified rays always start at slice 0; finished ones never.
template <int Dim>
void DirectionRanges<Dim>::fillUnsettled(FirstUnsettled unsettled) {
    forEachSectorOf(used_, [&](std::uint32_t sector) {
        std::fill_n(unsettled_.data() + perSector_ * sector, perSector_, unsettled);
    });
    unsettled_[bins_.unclassified()] = FirstUnsettled::all(0);
    unsettled_[bins_.finished()] = FirstUnsettled::never();
}

/// Takes the marks of coarse bins down to the finest level, where rays look.
template <int Dim>
void DirectionRanges<Dim>::completeUnsettled() {
    forEachSectorOf(used_, [&](std::uint32_t sector) {
        FirstUnsettled* const bins = unsettled_.data() + perSector_ * sector;
        for (int level = bins_.levels; level > 0; --level)
            spreadMarks(bins + levelBegin_[static_cast<std::size_t>(level)],
                        bins + levelBegin_[static_cast<std::size_t>(level - 1)],
                        bins_.edge(level));
    });
}

/// Takes the marks of a level down to the next finer one.
/// \param edge bins per minor axis of the coarse level
template <int Dim>
void DirectionRanges<Dim>::spreadMarks(const FirstUnsettled* coarse, FirstUnsettled* fine,
                                       std::uint32_t edge) {
    const std::uint32_t count = Dim == 3 ? edge * edge : edge;
    for (std::uint32_t b = 0; b < count; ++b) {
        const FirstUnsettled above = coarse[b];
        if (above.subBins() == 0) continue;
        FirstUnsettled* const below = fine + 4 * (b & ~(edge - 1)) + 2 * (b & (edge - 1));
        for (std::uint32_t y = 0; y < (Dim == 3 ? 2 : 1); ++y)
            for (std::uint32_t x = 0; x < 2; ++x) {
                const std::uint32_t subBins = subBinsBelow(above.subBins(), x, y);
                FirstUnsettled& to = below[2 * edge * y + x];
                if (subBins != 0) to = to.joined(FirstUnsettled::of(above.slice(), subBins));
            }
    }
}

/// Computes how far there is anything to look for: to the farthest end of the rays, or to the
/// slice from which on all of them are walked anyway.
template <int Dim>
void DirectionRanges<Dim>::updateVisibleEnds() {
    marked_ = 0;
    forEachSectorOf(used_, [&](std::uint32_t sector) {
        const std::uint32_t major = DirectionBins<Dim>::majorAxisOf(sector);
        Slice* const ends = visibleEnd_.data() + perSector_ * sector;
        const CellOffset* const farthest = farthest_.data() + perSector_ * sector;
        const FirstUnsettled* const unsettled = unsettled_.data() + perSector_ * sector;
        for (std::uint32_t b = 0; b < levelBegin_.data()[1]; ++b) {
            const auto end = static_cast<Slice>(farthest[b][major] + 1);
            const bool all = unsettled[b].subBins() == FirstUnsettled::kAllSubBins;
            ends[b] = std::min(end, all ? unsettled[b].slice() : kNever);
        }
        buildPyramid(ends, [](Slice x, Slice y) { return std::max(x, y); });
    });
}

/// Calls visit(block as seen by a sector) for the sectors whose rays may pass the block, until
/// it returns false.
///
/// A ray is in a cell only where its minor coordinates are between the cell's. So the slope of
/// a ray that passes the block is between (nearest minor / farthest major coordinate) and
/// (farthest minor / nearest major coordinate).
template <int Dim>
template <typename Visit>
void DirectionRanges<Dim>::forEachSector(const BlockKey<Dim>& block, const Visit& visit) const {
    const auto binsPerAxis = static_cast<float>(bins_.edge(0));
    const float lastBin = binsPerAxis - 1;
    const Cell<Dim> lowest = cellInBlock<Dim>(block, 0);
    for (std::uint32_t side = 0; side < 1u << Dim; ++side) {
        BlockInSector<Dim> s;
        bool there = true;
        for (int a = 0; a < Dim; ++a) {
            const bool back = s.back[a] = side >> a & 1;
            const std::int32_t highest = lowest[a] + kBlockEdge - 1;
            there &= back ? lowest[a] <= sensor_[a] : highest >= sensor_[a];
            const std::int32_t low = back ? sensor_[a] - highest : lowest[a] - sensor_[a];
            const float within = back ? 1 - within_[a] : within_[a];
            s.nearest[a] = std::max(low, 0);
            s.near[a] = static_cast<float>(s.nearest[a]) - within;
            s.far[a] = static_cast<float>(low + kBlockEdge) - within;
        }
        if (!there) continue;
        for (int d = 0; d < Dim; ++d) {
            s.sector = static_cast<std::uint32_t>(d) | side << 2;
            if ((used_ >> s.sector & 1) == 0) continue;
            s.major = d;
            const float perFar = 1 / s.far[d];
            const float perNear = perNearOf(s.near[d]);
            bool seen = true;
            s.low[1] = s.high[1] = 0;
            for (int a = 0, m = 0; a < Dim; ++a) {
                if (a == d) continue;
                const float low = (s.near[a] - kLag) * perFar - kSlopeError;
                const float high = (s.far[a] + kLag) * perNear + kSlopeError;
                seen &= low <= 1;
                s.low[m] =
                    static_cast<std::uint32_t>(std::clamp(low * binsPerAxis, 0.0f, lastBin));
                s.high[m] =
                    static_cast<std::uint32_t>(std::clamp(high * binsPerAxis, 0.0f, lastBin));
                ++m;
            }
            if (seen && !visit(s)) return;
        }
    }
}

template <int Dim>
bool DirectionRanges<Dim>::sees(const BlockKey<Dim>& block) const {
    bool reached = false;
    forEachSector(block, [&](const BlockInSector<Dim>& s) {
        CellOffset nearest{};
        for (int a = 0; a < Dim; ++a) nearest.set(a, s.nearest[a]);
        const std::uint32_t width = std::max(s.high[0] - s.low[0], s.high[1] - s.low[1]);
        // Two or three bins per axis.
        const int level = std::min(bins_.levels, std::max(0, bitLength(width) - 1));
        const std::uint32_t begin =
            s.sector * perSector_ + levelBegin_[static_cast<std::size_t>(level)];
        for (std::uint32_t y = s.low[1] >> level; y <= s.high[1] >> level; ++y)
            for (std::uint32_t x = s.low[0] >> level; x <= s.high[0] >> level; ++x) {
                const std::uint32_t bin = begin + (y << (bins_.levels - level)) + x;
                reached |= nearest.within(farthest_[bin]) &&
                           visibleEnd_[bin] > nearest[static_cast<unsigned>(s.major)];
            }
        return !reached;
    });
    return reached;
}

template <int Dim>
void DirectionRanges<Dim>::mark(const BlockKey<Dim>& block, const BlockMask<Dim>& cells) {
    static const MarkBoundary<Dim> kernel = bestKernels<Dim>().markBoundary;
    RangesView<Dim> view;
    view.sensor = sensor_;
    std::copy_n(within_, Dim, view.within);
    view.bins = bins_;
    view.levelBegin = levelBegin_.data();
    view.farthest = farthest_.data();
    view.unsettled = unsettled_.data();
    forEachSector(block, [&](const BlockInSector<Dim>& s) {
        marked_ += kernel(view, s, block, cells);
        return true;
    });
    if (marked_ >= SkippingCosts::kMarksPerUpdate) updateVisibleEnds();
}

template class DirectionRanges<2>;
template class DirectionRanges<3>;

}  // namespace superray
