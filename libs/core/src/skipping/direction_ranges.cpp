// SPDX-License-Identifier: BSD-3-Clause
#include "skipping/direction_ranges.h"

#include "kernels/walk_kernel.h"
#include "threads/interleave.h"

namespace superray {
namespace {

/// A bin's sub-bins as those of the bin below that covers its (x, y)th quarter.
std::uint32_t subBinsBelow(std::uint32_t subBins, std::uint32_t x, std::uint32_t y) {
    const std::uint32_t s = subBins >> (2 * x + 8 * y);
    const std::uint32_t rows = 3 * (s & 0x11) | 6 * (s & 0x22);  // columns twice
    return 0x11 * (rows & 0x0F) | 0x110 * (rows & 0xF0);
}

}  // namespace

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
void DirectionRanges<Dim>::use(std::uint32_t sectors) {
    for (std::uint32_t left = sectors & ~used_; left != 0; left &= left - 1)
        std::fill_n(farthest_.data() +
                        std::size_t{perSector_} * static_cast<unsigned>(__builtin_ctz(left)),
                    perSector_, CellOffset{});
    used_ |= sectors;
}

template <int Dim>
void DirectionRanges<Dim>::addRays(const ClassifiedBatch<Dim>& directions,
                                   const std::uint32_t* rays, std::size_t count) {
    use(directions.sectors);
    farthestGrows_.learn(farthestGrows_.unpredictable()
                             ? addInterleaved<Branches::none>(directions, rays, count)
                             : addInterleaved<Branches::predicted>(directions, rays, count),
                         count);
}

/// Neighbours often go the same way.
/// \return number of rays that changed something
template <int Dim>
template <Branches branches>
std::size_t DirectionRanges<Dim>::addInterleaved(const ClassifiedBatch<Dim>& directions,
                                                 const std::uint32_t* rays, std::size_t count) {
    std::size_t changes = 0;
    interleave(count, [&](std::size_t, std::size_t i) {
        const CellOffset end = directions.endOffset[rays[i]];
        // That of the unclassified bin is not used.
        CellOffset& farthest = farthest_[DirectionBins<Dim>::binOf(directions.subBin[rays[i]])];
        const bool change = !end.within(farthest);
        changes += change;
        if (branches == Branches::none || change) farthest = farthest.joined(end);
    });
    return changes;
}

template <int Dim>
void DirectionRanges<Dim>::completeFarthest() {
    for (std::uint32_t left = used_; left != 0; left &= left - 1) {
        CellOffset* const sector =
            farthest_.data() + perSector_ * static_cast<unsigned>(__builtin_ctz(left));
        for (std::uint32_t t = 0; t < levelBegin_.data()[1]; ++t)
            binsWithRays_ += sector[t] != CellOffset();
        raise(sector, [](CellOffset x, CellOffset y) { return x.joined(y); });
    }
}

/// Fills in the coarser levels of a sector: what is joined of the bins below.
template <int Dim>
template <typename Value, typename Join>
void DirectionRanges<Dim>::raise(Value* sector, const Join& join) const {
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

template <int Dim>
void DirectionRanges<Dim>::clear() {
    fillUnsettled(FirstUnsettled::never());
    updateVisibleEnds();
}

template <int Dim>
void DirectionRanges<Dim>::markAll() {
    fillUnsettled(FirstUnsettled::all(0));
}

/// All bins, but that of the unclassified rays, which are walked from the beginning.
template <int Dim>
void DirectionRanges<Dim>::fillUnsettled(FirstUnsettled unsettled) {
    for (std::uint32_t left = used_; left != 0; left &= left - 1)
        std::fill_n(unsettled_.data() +
                        std::size_t{perSector_} * static_cast<unsigned>(__builtin_ctz(left)),
                    perSector_, unsettled);
    unsettled_[bins_.unclassified()] = FirstUnsettled::all(0);
    unsettled_[bins_.finished()] = FirstUnsettled::never();
}

template <int Dim>
void DirectionRanges<Dim>::completeUnsettled() {
    for (std::uint32_t left = used_; left != 0; left &= left - 1) {
        FirstUnsettled* const sector =
            unsettled_.data() + perSector_ * static_cast<unsigned>(__builtin_ctz(left));
        for (int level = bins_.levels; level > 0; --level) {
            FirstUnsettled* const fine =
                sector + levelBegin_[static_cast<std::size_t>(level - 1)];
            const FirstUnsettled* const coarse =
                sector + levelBegin_[static_cast<std::size_t>(level)];
            const std::uint32_t edge = bins_.edge(level);
            const std::uint32_t count = Dim == 3 ? edge * edge : edge;
            for (std::uint32_t t = 0; t < count; ++t) {
                const FirstUnsettled above = coarse[t];
                if (above.subBins() == 0) continue;
                FirstUnsettled* const below =
                    fine + 4 * (t & ~(edge - 1)) + 2 * (t & (edge - 1));
                for (std::uint32_t y = 0; y < (Dim == 3 ? 2 : 1); ++y)
                    for (std::uint32_t x = 0; x < 2; ++x) {
                        const std::uint32_t subBins = subBinsBelow(above.subBins(), x, y);
                        FirstUnsettled& to = below[2 * edge * y + x];
                        if (subBins != 0)
                            to = to.joined(FirstUnsettled::of(above.slice(), subBins));
                    }
            }
        }
    }
}

/// How far there is something to see: as far as rays reach, but not where all of them
/// are walked anyway.
template <int Dim>
void DirectionRanges<Dim>::updateVisibleEnds() {
    marked_ = 0;
    for (std::uint32_t left = used_; left != 0; left &= left - 1) {
        const auto id = static_cast<unsigned>(__builtin_ctz(left));
        const unsigned d = id & 3;
        Slice* const sector = visibleEnd_.data() + perSector_ * id;
        const CellOffset* const farthest = farthest_.data() + perSector_ * id;
        const FirstUnsettled* const unsettled = unsettled_.data() + perSector_ * id;
        for (std::uint32_t t = 0; t < levelBegin_.data()[1]; ++t) {
            const auto end = static_cast<Slice>(farthest[t][d] + 1);
            const bool all = unsettled[t].subBins() == FirstUnsettled::kAllSubBins;
            sector[t] = std::min(end, all ? unsettled[t].slice() : kNever);
        }
        raise(sector, [](Slice x, Slice y) { return std::max(x, y); });
    }
}

/// A ray visits a cell in slice k only if, somewhere between entering and leaving
/// the slice, its minor coordinates are within those of the cell. So its slope is
/// between (nearest minor / farthest major) and (farthest / nearest).
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
void DirectionRanges<Dim>::markBoundary(const BlockKey<Dim>& block,
                                        const BlockMask<Dim>& cells) {
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
    constexpr std::uint32_t kMany = 4096;
    if (marked_ >= kMany) updateVisibleEnds();
}

template class DirectionRanges<2>;
template class DirectionRanges<3>;

}  // namespace superray
