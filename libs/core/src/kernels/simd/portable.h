// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The interface of vector code to an instruction set, and what each operation
// means: the loops here are the definition. Avx2 and Avx512 have the same
// operations.

#include <superray/core/ray_line.h>

#include "directions/classified_batch.h"
#include "directions/first_unsettled.h"
#include "kernels/simd/address_part.h"

#include <cstring>

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

struct Portable {
    /// Lines are walked cell by cell: without wide registers that is faster.
    static constexpr bool kWalksLanes = false;
    /// Whether floor() of a double is one instruction.
    static constexpr bool kHasFloor = false;
    /// What points are copied with: registers of coordinates.
    using Floats = float __attribute__((vector_size(16)));
    using Doubles = double __attribute__((vector_size(16)));
    /// Rays at once when looking for runs, and when choosing: one, no vectors.
    static constexpr int kRunLanes = 1, kChoiceLanes = 1;

    /// 8 x int64: coordinates in units of 2^-31 cells, or slopes.
    using Long8 = std::int64_t __attribute__((vector_size(64)));
    using Double8 = double __attribute__((vector_size(64)));
    /// A set of lanes: -1 in those that belong to it.
    using Mask = Ints;

    /// { base, base + step, ..., base + 7 * step }. \pre 0 <= step < 2^32
    static Long8 ramp(std::int64_t base, std::int64_t step) {
        return base + step * Long8{0, 1, 2, 3, 4, 5, 6, 7};
    }
    /// x in all lanes.
    static Long8 all(std::int64_t x) { return Long8{} + x; }
    /// floor(units / 2^31): the cell that holds each coordinate.
    /// Example: 5 * 2^31 + 7 -> 5, and -1 -> -1.
    static Ints cells(Long8 units) { return __builtin_convertvector(units >> kUnitBits, Ints); }
    /// units / 2^31 of what is not negative.
    static Long8 wholeUnits(Long8 units) { return units >> kUnitBits; }
    /// a * b of the low 32 bits, which have no sign.
    static Long8 product(Long8 a, Long8 b) {
        using Unsigned8 = std::uint64_t __attribute__((vector_size(64)));
        const auto low = [](Long8 x) { return reinterpret_cast<Unsigned8>(x) & 0xFFFFFFFF; };
        return reinterpret_cast<Long8>(low(a) * low(b));
    }
    /// int32 to int64; the high halves of negative ones: any.
    static Long8 wide(Ints x) { return __builtin_convertvector(x, Long8); }
    /// to[i] = a[i]
    static void store(Long8 a, std::int64_t* to) { std::memcpy(to, &a, sizeof a); }

    /// base[indices[i]] as doubles, of 8 indices.
    template <typename Scalar>
    static Double8 gatherDoubles(const Scalar* base, const std::uint32_t* indices) {
        Double8 v;
        for (int i = 0; i < 8; ++i) v[i] = double{base[indices[i]]};
        return v;
    }
    static Double8 times(Double8 a, double x) { return a * x; }
    static Double8 over(Double8 a, Double8 b) { return a / b; }
    /// floor(x[i]). \pre |x[i]| < 2^51
    static Long8 floorOf(Double8 x) {
        Long8 v;
        for (int i = 0; i < 8; ++i) v[i] = static_cast<std::int64_t>(__builtin_floor(x[i]));
        return v;
    }
    /// \pre 0 <= i < 2^52
    static Double8 toDouble(Long8 i) { return __builtin_convertvector(i, Double8); }

    /// The lanes whose bits are set. Example: 0b101 -> lanes 0 and 2.
    static Mask maskOf(int bits) {
        return -((Ints{} + bits) >> Ints{0, 1, 2, 3, 4, 5, 6, 7} & 1);
    }
    /// The reverse: bit i is the sign bit of lane i.
    static int bitsOf(Ints mask) {
        int bits = 0;
        for (int i = 0; i < 8; ++i) bits |= (mask[i] < 0 ? 1 : 0) << i;
        return bits;
    }
    /// Bits of the lanes in which a and b differ.
    static int differing(Ints a, Ints b) { return bitsOf(a != b); }
    /// mask ? a : b, lane by lane.
    static Ints select(Mask mask, Ints a, Ints b) { return (mask & a) | (~mask & b); }
    /// Each lane of x moves up by one; lane 7 of `before` comes in:
    /// { before[7], x[0], x[1], ..., x[6] }.
    static Ints following(Ints x, Ints before) {
        return Ints{before[7], x[0], x[1], x[2], x[3], x[4], x[5], x[6]};
    }
    /// table[sum[i] & 3]. \pre lanes 4 to 7 of the table repeat lanes 0 to 3
    static UInts pickOf4(UInts table, UInts sum) {
        UInts v;
        for (int i = 0; i < 8; ++i) v[i] = table[sum[i] & 3];
        return v;
    }
    /// { a, b, c, d, a, b, c, d }
    static UInts twice(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        return UInts{a, b, c, d, a, b, c, d};
    }
    /// base[indices[i]]
    static Ints gatherInts(const std::int32_t* base, Ints indices) {
        Ints v;
        for (int i = 0; i < 8; ++i) v[i] = base[indices[i]];
        return v;
    }
    /// Appends the lanes of the mask at `out`, in order; up to 8 elements are
    /// written. \return the new end. Example: { 9, 8, 7, ... } and 0b101 -> 9, 7.
    static std::uint32_t* compress(std::uint32_t* out, UInts v, int mask) {
        for (int i = 0; i < 8; ++i)
            if (mask >> i & 1) *out++ = v[i];
        return out;
    }

    /// Lanes in which axis a crosses its next border before axis b. The distances
    /// to the borders are toA and toB, both in (0, 2^31]; a crosses first if toA
    /// / slopeA < toB / slopeB, and as exact products: toA * slopeB < toB *
    /// slopeA.
    static Mask firstCrosses(Long8 a, Long8 slopeA, Long8 b, Long8 slopeB) {
        const Long8 toA = kUnitsPerCell - (a & (kUnitsPerCell - 1));
        const Long8 toB = kUnitsPerCell - (b & (kUnitsPerCell - 1));
        return __builtin_convertvector(product(toA, slopeB) < product(toB, slopeA), Ints);
    }
    /// addressPart() of one minor axis.
    template <int minor, int axis>
    class Parts {
     public:
        explicit Parts(std::int32_t flip) : flip_(Ints{} + flip) {}
        Ints of(Ints cells) const { return addressPart<minor, axis>(cells, flip_); }

     private:
        Ints flip_;
    };

    /// Bit i: counts[i] >= least, of 64 counts. \pre least >= 1
    static std::uint64_t atLeast64(const std::uint8_t* counts, std::uint32_t least) {
        std::uint64_t bits = 0;
        for (int i = 0; i < 64; ++i) bits |= std::uint64_t{counts[i] >= least} << i;
        return bits;
    }

    /// A boundary cell into up to 8 bins in a row: in those whose farthest end is
    /// not nearer than `offset`, the sub-bins are unsettled from `slice` on.
    /// \param columns 4 bits for each bin: the columns of sub-bins meant
    /// \param rows bits 0, 4, 8, 12: the rows of sub-bins meant, in all bins
    /// \return how many of the bins change and are unsettled in all sub-bins then
    /// Example: columns 0x3C and rows 0x0011 mean, in bin 0, columns 2 and 3 of
    /// rows 0 and 1: 0xC * 0x0011 = 0x00CC, and in bin 1, 0x3 * 0x0011 = 0x0033.
    static std::uint32_t markRow(FirstUnsettled* unsettled, const CellOffset* farthest,
                                 CellOffset offset, std::int32_t slice, std::uint32_t columns,
                                 std::uint32_t rows) {
        std::uint32_t changed = 0;
        for (; columns != 0; columns >>= 4, ++unsettled, ++farthest) {
            const std::uint32_t subBins = (columns & 15) * rows;
            const FirstUnsettled now =
                unsettled->joined(FirstUnsettled::of(static_cast<Slice>(slice), subBins));
            if (subBins == 0 || now.word == unsettled->word || !offset.within(*farthest))
                continue;
            *unsettled = now;
            changed += now.subBins() == FirstUnsettled::kAllSubBins;
        }
        return changed;
    }
};

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
