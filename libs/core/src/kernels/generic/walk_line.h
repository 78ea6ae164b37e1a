// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The free cells of a ray, 8 slices at a time.
//
// Lanes are the slices of one aligned group of 8 major cells. So a group lies
// in one layer of blocks, and since slopes are at most 1, it meets at most two
// blocks per minor axis: an even one and an odd one. The ids of these blocks
// make a table of four (of two, in 2D), from which each lane picks the one of
// its cell. A slice visits
//   A: the cell in which it is entered, always;
//   B: the cell in which it is left, if that is another one;
//   C: a cell between, if both minor axes step.
// Addresses are collected without branches and counted later.
//
// Example in 2D, slope 1/4, from the middle of cell (0, 0): slices 0 and 1 stay
// in row 0, slice 2 enters in row 0 and is left in row 1: A gives (0, 0) (1, 0)
// (2, 0), B (2, 1).

#include <superray/core/ray_line.h>
#include <superray/core/traversal.h>

#include "counting/scan_counts.h"
#include "kernels/simd/lanes.h"
#include "kernels/walk_kernel.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

/// One minor axis of a walk. The walk takes 8 slices at a time, a group, in which a ray
/// enters at most two blocks of this axis. Coordinates are mirrored, see RayLine.
struct MinorAxis {
    std::int64_t entering, step;  ///< units on entering the group; per group
    std::int64_t block;           ///< in which the group is entered
    std::int64_t stride, begin;   ///< the block's index in the directory is
    std::int64_t index;           ///< block * stride + begin
    std::int64_t at[2];           ///< indices of the group's even and odd block

    SUPERRAY_INLINE std::int64_t indexOf(std::int64_t b) const { return b * stride + begin; }
    /// Goes to the next group, which is left in the block `high`:
    /// at[block & 1] = index; at[~block & 1] = indexOf(high)
    SUPERRAY_INLINE void advanceTo(std::int64_t high) {
        const std::int64_t highIndex = indexOf(high);
        // By arithmetic: a branch would often be mispredicted.
        const std::int64_t swap = (index ^ highIndex) & -(block & 1);
        at[0] = index ^ swap;
        at[1] = highIndex ^ swap;
        block = high;
        index = highIndex;
    }
};

/// The id of one of a group's blocks, which is made if it is missing.
/// \param pick bit m: the odd block of minor axis m
template <int Dim, int D>
std::uint32_t idOfPicked(ScanCounts<Dim>& counts, std::int32_t majorBlock,
                         const MinorAxis* minor, int pick) {
    BlockKey<Dim> key;
    key[D] = majorBlock;
    for (int m = 0; m < Dim - 1; ++m) {
        const int a = minorAxis<D>(m);
        key[a] =
            static_cast<std::int32_t>(minor[m].at[pick >> m & 1] / counts.directory.stride(a)) +
            counts.directory.box().lo[a];
    }
    return counts.idOf(key);
}

/// One walk. \pre the major axis is D; no axis steps twice in the last slice;
/// from < line.slices()
template <typename Simd, int Dim, int D>
class LineWalk {
    static constexpr int kMinors = Dim - 1;
    static constexpr int kOther = kMinors - 1;  ///< the second minor axis, if there is one
    using Long8 = typename Simd::Long8;

 public:
    SUPERRAY_INLINE LineWalk(ScanCounts<Dim>& counts, const RayLine<Dim>& line,
                             std::int32_t from)
        : counts_(counts),
          line_(line),
          from_(from),
          parts0_(line.flip[minorAxis<D>(0)]),
          parts1_(line.flip[minorAxis<D>(kOther)]) {
        const BlockDirectory<Dim>& directory = counts.directory;
        // First slice of the aligned group that holds `from`; may be negative.
        const std::int32_t phase = line.first[D] & 7;
        k0_ = ((from + phase) & ~7) - phase;
        const Ints lanes = {0, 1, 2, 3, 4, 5, 6, 7};
        majorPart_ = ((lanes ^ line.flip[D]) & 7) << (kBlockBits * D + kPickBits);
        for (int m = 0; m < kMinors; ++m) begin(m, minorAxis<D>(m));
        majorBlock_ = ((line.first[D] + k0_) >> kBlockBits) ^ line.flip[D];
        majorIndex_ = (majorBlock_ - directory.box().lo[D]) * directory.stride(D);
        forward_ = 1 + 2 * line.flip[D];
        out_ = counts.addresses.end();
    }

    /// Appends the cells from slice `from` on.
    SUPERRAY_INLINE void run() {
        const std::int32_t last = line_.slices() - 1;
        const auto atEnd = [&] { return last - k0_ < 8 ? 1 << (last - k0_) : 0; };
        walkGroup(std::false_type{}, 1 << (from_ - k0_), atEnd());
        for (k0_ += 8; k0_ + 8 <= last; k0_ += 8) walkGroup(std::true_type{}, 0, 0);
        if (k0_ <= last) walkGroup(std::false_type{}, 0, atEnd());
        counts_.addresses.setEnd(out_);
    }

 private:
    /// Sets up minor axis m, which is axis a.
    SUPERRAY_INLINE void begin(int m, int a) {
        const BlockDirectory<Dim>& directory = counts_.directory;
        MinorAxis& axis = minor_[m];
        axis.entering = line_.atExit(a, k0_ - 1);
        axis.step = 8 * line_.slope[a];
        // Block b, not mirrored, is at (b - lowest) * stride; mirrored, b is ~b.
        const std::int64_t sign = 1 + 2 * line_.flip[a];
        axis.stride = sign * directory.stride(a);
        axis.begin =
            (line_.flip[a] - std::int64_t{directory.box().lo[a]}) * directory.stride(a);
        // A group that begins before the ray is entered where the ray begins.
        axis.block =
            std::max(line_.first[a], RayLine<Dim>::cellOfUnits(axis.entering)) >> kBlockBits;
        axis.index = axis.indexOf(axis.block);
        slopes_[m] = Simd::all(line_.slope[a]);
        steps_[m] = Simd::all(axis.step);
        exits_[m] = Simd::ramp(axis.entering + line_.slope[a], line_.slope[a]);
        start_[m] = partOf(m, Ints{} + line_.entryCell(a, from_));
        end_[m] = partOf(m, Ints{} + line_.last[a]);
        before_[m] = start_[m];
    }
    SUPERRAY_INLINE Ints partOf(int m, Ints cell) const {
        return m == 0 ? parts0_.of(cell) : parts1_.of(cell);
    }

    /// offsets[pick] of the group's blocks in the arena: pick 0 is the block that
    /// is even on both minor axes, bit m of `pick` means the odd one on minor
    /// axis m.
    SUPERRAY_INLINE UInts blockOffsets() {
        const std::uint32_t* const ids = counts_.directory.data() + majorIndex_;
        const std::int64_t other[2] = {kMinors == 2 ? minor_[kOther].at[0] : 0,
                                       kMinors == 2 ? minor_[kOther].at[1] : 0};
        UInts id = Simd::twice(ids[minor_[0].at[0] + other[0]], ids[minor_[0].at[1] + other[0]],
                               kMinors == 2 ? ids[minor_[0].at[0] + other[1]] : 1,
                               kMinors == 2 ? ids[minor_[0].at[1] + other[1]] : 1);
        if (__builtin_expect(Simd::bitsOf(id == 0) != 0, 0)) {
            // A copy: an object whose address is passed on is not kept in registers.
            MinorAxis minor[kMinors];
            for (int m = 0; m < kMinors; ++m) minor[m] = minor_[m];
            std::uint32_t made[4];
            for (int pick = 0; pick < 4; ++pick)
                made[pick] = pick < 1 << kMinors
                                 ? idOfPicked<Dim, D>(counts_, majorBlock_, minor, pick)
                                 : 1;
            id = Simd::twice(made[0], made[1], made[2], made[3]);
        }
        return (id - 1) << (kBlockBits * Dim);
    }
    /// The address of each lane's cell, of its parts on the minor axes:
    /// offsets[sum & 3] + (sum >> 2)
    SUPERRAY_INLINE UInts addresses(UInts offsets, Ints part0, Ints part1) const {
        Ints sum = part0 + majorPart_;
        if constexpr (kMinors == 2) sum += part1;
        return Simd::pickOf4(offsets, (UInts)sum) + ((UInts)sum >> kPickBits);
    }
    /// The counts will soon be wanted; most groups have one or two cache lines.
    SUPERRAY_INLINE void prefetch(UInts addresses) const {
        const std::uint8_t* const misses = counts_.batch.missArena();
        __builtin_prefetch(misses + addresses[0], 1);
        __builtin_prefetch(misses + addresses[7], 1);
    }

    /// \param inside whether the ray neither begins nor ends in the group:
    /// true_type spares it what is only for these. \param atStart,atEnd the lane
    /// of the slice `from` and that of the last one, as a bit; 0: not in this
    /// group
    template <typename Inside>
    SUPERRAY_INLINE void walkGroup(Inside, int atStart, int atEnd) {
        constexpr bool kInside = Inside::value;
        for (int m = 0; m < kMinors; ++m) {
            MinorAxis& axis = minor_[m];
            axis.entering += axis.step;
            axis.advanceTo(!kInside && atEnd != 0 ? line_.last[minorAxis<D>(m)] >> kBlockBits
                                                  : axis.entering >> (kUnitBits + kBlockBits));
        }
        const UInts offsets = blockOffsets();
        // Lanes from atStart to atEnd.
        const int valid =
            (atStart != 0 ? -atStart : -1) & (atEnd != 0 ? 2 * atEnd - 1 : -1) & 0xFF;
        Ints entry[kMinors], exit[kMinors];
        int step[kMinors], anyStep = 0;
        for (int m = 0; m < kMinors; ++m) {
            exit[m] = partOf(m, Simd::cells(exits_[m]));
            entry[m] = Simd::following(exit[m],
                                       before_[m]);  // a slice begins as the last ends
            before_[m] = exit[m];
            if constexpr (!kInside) {
                entry[m] = Simd::select(Simd::maskOf(atStart), start_[m], entry[m]);
                exit[m] = Simd::select(Simd::maskOf(atEnd), end_[m], exit[m]);
            }
            step[m] = Simd::differing(entry[m], exit[m]) & valid;
            anyStep |= step[m];
        }
        // A. In the last slice a ray is left in its end cell, which is not free.
        const UInts entered = addresses(offsets, entry[0], entry[kOther]);
        prefetch(entered);
        if constexpr (kInside) {
            std::memcpy(out_, &entered, sizeof entered);
            out_ += 8;
        } else {
            out_ = Simd::compress(out_, entered, valid & (anyStep | ~atEnd));
        }
        // B.
        out_ =
            Simd::compress(out_, addresses(offsets, exit[0], exit[kOther]), anyStep & ~atEnd);
        if constexpr (kMinors == 2)
            walkBetween<kInside>(offsets, entry, exit, step[0] & step[1], atStart);
        for (int m = 0; m < kMinors; ++m) exits_[m] = exits_[m] + steps_[m];
        majorBlock_ += forward_;
        majorIndex_ += forward_ * counts_.directory.stride(D);
    }

    /// C: of the slices in which both axes step, the cell between:
    /// axis 0 crosses its border first ? (exit0, entry1) : (entry0, exit1)
    template <bool kInside>
    SUPERRAY_INLINE void walkBetween(UInts offsets, const Ints (&entry)[kMinors],
                                     const Ints (&exit)[kMinors], int both, int atStart) {
        if (!kInside && from_ == 0 && (both & atStart) != 0) {
            // Slice 0 is entered before the ray begins: compare in full.
            *out_++ = firstCellBetween();
            both &= ~atStart;
        }
        // Some groups have none, but which cannot be foreseen, so asking takes
        // longer.
        const typename Simd::Mask first = Simd::firstCrosses(
            exits_[0] - slopes_[0], slopes_[0], exits_[1] - slopes_[1], slopes_[1]);
        out_ = Simd::compress(out_,
                              addresses(offsets, Simd::select(first, exit[0], entry[0]),
                                        Simd::select(first, entry[1], exit[1])),
                              both);
    }
    SUPERRAY_INLINE std::uint32_t firstCellBetween() const {
        Cell<Dim> c = line_.first;
        const int a = minorAxis<D>(0), b = minorAxis<D>(kOther);
        ++c[line_.crossesBefore(a, c[a], b, c[b]) ? a : b];
        c = line_.unmirrored(c);
        return counts_.offsetOf(blockOf<Dim>(c)) +
               static_cast<std::uint32_t>(indexInBlock<Dim>(c));
    }

    ScanCounts<Dim>& counts_;
    const RayLine<Dim>& line_;
    const std::int32_t from_;
    std::int32_t k0_;  ///< the group's first slice
    typename Simd::template Parts<0, minorAxis<D>(0)> parts0_;
    typename Simd::template Parts<kOther, minorAxis<D>(kOther)> parts1_;
    Ints majorPart_;
    MinorAxis minor_[kMinors];
    Long8 exits_[kMinors], slopes_[kMinors],
        steps_[kMinors];                                    ///< of the lanes' slices
    Ints before_[kMinors], start_[kMinors], end_[kMinors];  ///< parts of addresses
    std::int32_t majorBlock_, forward_;
    std::int64_t majorIndex_;
    std::uint32_t* out_;
};

/// Whether each axis steps at most once in the last slice (it may step twice
/// where rounding is made up for).
template <int Dim>
inline bool stepsOnceAtEnd(const RayLine<Dim>& line) {
    const std::int32_t k = line.slices() - 1;
    bool once = true;
    for (int a = 0; a < Dim; ++a) once &= line.last[a] - line.entryCell(a, k) <= 1;
    return once;
}

/// As WalkKernel.
template <typename Simd, int Dim>
void walkLine(ScanCounts<Dim>& counts, const RayLine<Dim>& line, std::int32_t from) {
    if constexpr (!Simd::kWalksLanes) {
        walkPortable(counts, line, from, line.slices());
    } else {
        if (from >= line.slices()) return;
        if (!stepsOnceAtEnd(line)) return walkPortable(counts, line, from, line.slices());
        switch (line.major) {
            case 0:
                return LineWalk<Simd, Dim, 0>(counts, line, from).run();
            case 1:
                return LineWalk<Simd, Dim, 1>(counts, line, from).run();
            default:
                return LineWalk<Simd, Dim, Dim - 1>(counts, line, from).run();
        }
    }
}

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
