// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Boundary cells into the bins of a scan's directions.

#include <superray/core/block.h>

#include "directions/ranges_view.h"
#include "kernels/generic/footprints.h"
#include "kernels/simd/lanes.h"

#include <algorithm>
#include <utility>

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

/// A ray passes a cell only if it is within the cell's bounds on both minor
/// axes at once, while a footprint lets it be so at different places of the
/// slice. Close to the sensor, that makes footprints far too large. So those of
/// so many sub-bins are put together from those of thinner slices.
constexpr std::int32_t kLargeFootprint = 1024;
constexpr int kParts = 4;

/// Rows and columns of the 8 x 8 bits of a layer of cells, exchanged.
inline std::uint64_t transposed(std::uint64_t x) {
    const auto exchange = [&x](int by, std::uint64_t mask) {
        const std::uint64_t t = (x ^ x >> by) & mask;
        x ^= t ^ t << by;
    };
    exchange(7, 0x00AA00AA00AA00AA);
    exchange(14, 0x0000CCCC0000CCCC);
    exchange(28, 0x00000000F0F0F0F0);
    return x;
}

/// Marks the sub-bins x * y of the bins whose farthest end is not nearer than
/// `offset`. \param sector its first bin \return as MarkBoundary
template <typename Simd, int Dim>
std::uint32_t markSubBins(const RangesView<Dim>& h, std::uint32_t sector, SubBinRange x,
                          SubBinRange y, std::uint64_t offset, std::int32_t slice) {
    constexpr int kAxisBits = DirectionBins<Dim>::kAxisSubBinBits;
    constexpr std::int32_t kAxisSubBins = DirectionBins<Dim>::kAxisSubBins;
    const int levels = h.bins.levels;
    const auto edge = static_cast<std::int32_t>(h.bins.edge(0)) * kAxisSubBins;
    std::uint32_t changed = 0;
    if (x.first >= edge || y.first >= edge) return changed;
    // At most 61 columns of sub-bins, for with up to 3 before them they must fit
    // 64 bits, and about 8 rows of bins.
    const int width = std::max((9 * (x.last - x.first) >> 4) + 1, y.last - y.first);
    const int level =
        std::max(0, bitLength(static_cast<std::uint32_t>(width)) - (kAxisBits + 3));
    const std::int32_t fromX = x.first >> level, toX = (x.last >> level) + 1;
    const std::int32_t fromY = y.first >> level, toY = (y.last >> level) + 1;
    const std::uint64_t columns = ((std::uint64_t{1} << (toX - fromX)) - 1)
                                  << (fromX & (kAxisSubBins - 1));
    for (std::int32_t row = fromY >> kAxisBits; row << kAxisBits < toY; ++row) {
        std::uint32_t rows = 0x1111;
        if (Dim == 3) {
            const std::int32_t skip = std::max(0, fromY - (row << kAxisBits));
            const std::int32_t end = std::min(kAxisSubBins, toY - (row << kAxisBits));
            rows = rows >> (4 * (skip + kAxisSubBins - end)) << (4 * skip);
        }
        std::uint32_t bin = sector + h.levelBegin[level] +
                            (static_cast<std::uint32_t>(row) << (levels - level)) +
                            static_cast<std::uint32_t>(fromX >> kAxisBits);
        for (std::uint64_t more = columns; more != 0; more >>= 32, bin += 8)
            changed += Simd::markRow(h.unsettled + bin, h.farthest + bin, CellOffset(offset),
                                     slice, static_cast<std::uint32_t>(more), rows);
    }
    return changed;
}

/// The boundary cells of a block, run by run along the first minor axis: cells
/// in a row are marked at once, as if they were as near as the nearest of them.
template <typename Simd, int Dim>
class BoundaryMarker {
 public:
    SUPERRAY_INLINE BoundaryMarker(const RangesView<Dim>& ranges,
                                   const BlockInSector<Dim>& sight, const BlockKey<Dim>& block)
        : ranges_(ranges),
          sight_(sight),
          footprints_(ranges, sight, block),
          firstBin_(sight.sector * ranges.bins.perSector()),
          major_(sight.major),
          minor0_(major_ == 0 ? 1 : 0),
          minor1_(major_ == Dim - 1 ? Dim - 2 : Dim - 1) {}

    /// \return as MarkBoundary
    SUPERRAY_INLINE std::uint32_t mark(const BlockMask<Dim>& cells) {
        for (int w = 0; w < BlockMask<Dim>::kWords; ++w) {
            std::uint64_t left = major_ == 0 ? transposed(cells.words[w]) : cells.words[w];
            int at[Dim] = {};
            at[Dim - 1] = w;  // in 2D, there is but one word
            if (Dim == 3 && (footprints_.seen[Dim - 1] >> w & 1) == 0) continue;
            const int across = major_ == 0 ? 0 : 1;  // axis of the rows' numbers
            for (int r = 0; left != 0; ++r, left >>= 8) {
                if ((footprints_.seen[across] >> r & 1) == 0) continue;
                at[across] = r;
                for (std::uint32_t row =
                         static_cast<std::uint32_t>(left) & footprints_.seen[minor0_] & 0xFF;
                     row != 0;) {
                    const int first = __builtin_ctz(row);
                    const int count = __builtin_ctz(~(row >> first));
                    markRun(at, first, first + count - 1);
                    row &= ~(((1u << count) - 1) << first);
                }
            }
        }
        return changed_;
    }

 private:
    SUPERRAY_INLINE void markRun(const int (&at)[Dim], int first, int last) {
        const auto [near, far] =
            sight_.back[minor0_] ? std::pair{last, first} : std::pair{first, last};
        const Footprints<Dim>& f = footprints_;
        const int k = at[major_];
        std::uint64_t offset = f.offset[minor0_][near] | f.offset[major_][k];
        const SubBinRange x = f.range(0, near, far, k);
        if constexpr (Dim == 2) {
            markProduct(x, SubBinRange{0, 0}, offset, k);
        } else {
            const int j = at[minor1_];
            offset |= f.offset[minor1_][j];
            const SubBinRange y = f.range(1, j, j, k);
            if ((x.last - x.first) * (y.last - y.first) < kLargeFootprint) {
                markProduct(x, y, offset, k);
                return;
            }
            constexpr float kPart = 1.0f / kParts;
            for (int part = 0; part < kParts; ++part) {
                const float begin = static_cast<float>(part) * kPart, end = begin + kPart;
                markProduct(f.rangeOfPart(0, near, far, k, begin, end),
                            f.rangeOfPart(1, j, j, k, begin, end), offset, k);
            }
        }
    }
    SUPERRAY_INLINE void markProduct(SubBinRange x, SubBinRange y, std::uint64_t offset,
                                     int k) {
        changed_ += markSubBins<Simd>(ranges_, firstBin_, x, y, offset, footprints_.slice[k]);
    }

    const RangesView<Dim>& ranges_;
    const BlockInSector<Dim>& sight_;
    const Footprints<Dim> footprints_;
    const std::uint32_t firstBin_;
    const int major_, minor0_, minor1_;
    std::uint32_t changed_ = 0;
};

/// As MarkBoundary.
template <typename Simd, int Dim>
std::uint32_t markBoundary(const RangesView<Dim>& ranges, const BlockInSector<Dim>& sight,
                           const BlockKey<Dim>& block, const BlockMask<Dim>& cells) {
    return BoundaryMarker<Simd, Dim>(ranges, sight, block).mark(cells);
}

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
