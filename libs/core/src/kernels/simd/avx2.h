// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Vector code for AVX2: registers of 256 bits. For the meaning of the
// operations see Portable.

#include <superray/core/ray_bundle.h>
#include <superray/core/ray_line.h>

#include "directions/classified_batch.h"
#include "kernels/simd/avx_common.h"

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

/// Per mask of 8 bits: the lanes in it, in order. Example: 0b101 -> 0, 2.
struct CompressTable {
    alignas(32) std::uint32_t lanes[256][8];
    constexpr CompressTable() : lanes() {
        for (unsigned mask = 0; mask < 256; ++mask) {
            int n = 0;
            for (unsigned lane = 0; lane < 8; ++lane)
                if (mask >> lane & 1) lanes[mask][n++] = lane;
        }
    }
};
constexpr CompressTable kCompress;

struct Avx2 : AvxCommon {
    using Floats = float __attribute__((vector_size(32)));
    using Doubles = double __attribute__((vector_size(32)));
    static constexpr int kRunLanes = 8;
    /// Its gather loads element by element: no faster than one ray at a time.
    static constexpr int kChoiceLanes = 1;

    /// Lanes 0, 1, 4, 5 are `low`, the others `high`: so the halves of 256-bit
    /// registers need not be crossed to make one of 32-bit lanes of both.
    struct Long8 {
        __m256i low, high;
        Long8 operator+(Long8 o) const {
            return {_mm256_add_epi64(low, o.low), _mm256_add_epi64(high, o.high)};
        }
        Long8 operator-(Long8 o) const {
            return {_mm256_sub_epi64(low, o.low), _mm256_sub_epi64(high, o.high)};
        }
    };
    struct Double8 {  // as Long8
        __m256d low, high;
    };
    using Mask = Ints;

    static Long8 ramp(std::int64_t base, std::int64_t step) {
        const __m256i start = _mm256_set1_epi64x(base), each = _mm256_set1_epi64x(step);
        return {
            _mm256_add_epi64(start, _mm256_mul_epu32(each, _mm256_setr_epi64x(0, 1, 4, 5))),
            _mm256_add_epi64(start, _mm256_mul_epu32(each, _mm256_setr_epi64x(2, 3, 6, 7)))};
    }
    static Long8 all(std::int64_t x) { return {_mm256_set1_epi64x(x), _mm256_set1_epi64x(x)}; }
    /// The low halves of 8 int64.
    static Ints narrow(Long8 a) {
        return (Ints)_mm256_castps_si256(
            _mm256_shuffle_ps(_mm256_castsi256_ps(a.low), _mm256_castsi256_ps(a.high), 0x88));
    }
    /// A logical shift will do: the sign is in the 32 bits that are kept.
    static Ints cells(Long8 units) { return narrow(wholeUnits(units)); }
    static Long8 wholeUnits(Long8 a) {
        return {_mm256_srli_epi64(a.low, kUnitBits), _mm256_srli_epi64(a.high, kUnitBits)};
    }
    static Long8 product(Long8 a, Long8 b) {
        return {_mm256_mul_epu32(a.low, b.low), _mm256_mul_epu32(a.high, b.high)};
    }
    static Long8 wide(Ints x) {
        return {_mm256_unpacklo_epi32((__m256i)x, _mm256_setzero_si256()),
                _mm256_unpackhi_epi32((__m256i)x, _mm256_setzero_si256())};
    }
    static void store(Long8 a, std::int64_t* to) {
        const auto lanes = reinterpret_cast<__m256i*>(to);
        _mm256_storeu_si256(lanes, _mm256_permute2x128_si256(a.low, a.high, 0x20));
        _mm256_storeu_si256(lanes + 1, _mm256_permute2x128_si256(a.low, a.high, 0x31));
    }

    template <typename Scalar>
    static Double8 gatherDoubles(const Scalar* base, const std::uint32_t* indices) {
        const auto at = [&](int i) { return double{base[indices[i]]}; };
        return {_mm256_setr_pd(at(0), at(1), at(4), at(5)),
                _mm256_setr_pd(at(2), at(3), at(6), at(7))};
    }
    static Double8 times(Double8 a, double x) { return {a.low * x, a.high * x}; }
    static Double8 over(Double8 a, Double8 b) { return {a.low / b.low, a.high / b.high}; }
    /// Added to a whole number below 2^51, it leaves that number in the low bits
    /// of the sum: 1.5 * 2^52, whose last bit is worth 1.
    static constexpr double kRounder = 6755399441055744.0;
    static __m256i floorOf4(__m256d x) {
        const __m256d rounder = _mm256_set1_pd(kRounder);
        return _mm256_sub_epi64(_mm256_castpd_si256(_mm256_floor_pd(x) + rounder),
                                _mm256_castpd_si256(rounder));
    }
    static Long8 floorOf(Double8 x) { return {floorOf4(x.low), floorOf4(x.high)}; }
    /// The other way: i in the low bits of 2^52 makes 2^52 + i.
    static __m256d toDouble4(__m256i i) {
        const __m256d great = _mm256_set1_pd(4503599627370496.0);  // 2^52
        return _mm256_castsi256_pd(_mm256_or_si256(i, _mm256_castpd_si256(great))) - great;
    }
    static Double8 toDouble(Long8 i) { return {toDouble4(i.low), toDouble4(i.high)}; }

    static Mask maskOf(int bits) {
        const Ints each = {1, 2, 4, 8, 16, 32, 64, 128};
        return ((Ints{} + bits) & each) == each;
    }
    static int differing(Ints a, Ints b) { return ~bitsOf(a == b) & 0xFF; }
    static Ints select(Mask mask, Ints a, Ints b) {
        return (Ints)_mm256_castps_si256(_mm256_blendv_ps(_mm256_castsi256_ps((__m256i)b),
                                                          _mm256_castsi256_ps((__m256i)a),
                                                          _mm256_castsi256_ps((__m256i)mask)));
    }
    static Ints following(Ints x, Ints before) {
        const __m256i halves =
            _mm256_permute2x128_si256((__m256i)before, (__m256i)x, 0x21);  // before 4-7, x 0-3
        return (Ints)_mm256_alignr_epi8((__m256i)x, halves, 12);
    }
    static std::uint32_t* compress(std::uint32_t* out, UInts v, unsigned mask) {
        return compress(out, v, static_cast<int>(mask));
    }
    static std::uint32_t* compress(std::uint32_t* out, UInts v, int mask) {
        const __m256i order =
            _mm256_load_si256(reinterpret_cast<const __m256i*>(kCompress.lanes[mask]));
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(out),
                            _mm256_permutevar8x32_epi32((__m256i)v, order));
        return out + __builtin_popcount(static_cast<unsigned>(mask));
    }

    static __m256i toBorder(__m256i units) {
        return _mm256_sub_epi64(_mm256_set1_epi64x(kUnitsPerCell),
                                _mm256_and_si256(units, _mm256_set1_epi64x(kUnitsPerCell - 1)));
    }
    static __m256i firstCrosses4(__m256i a, __m256i slopeA, __m256i b, __m256i slopeB) {
        return _mm256_cmpgt_epi64(_mm256_mul_epu32(toBorder(b), slopeA),
                                  _mm256_mul_epu32(toBorder(a), slopeB));
    }
    static Mask firstCrosses(Long8 a, Long8 slopeA, Long8 b, Long8 slopeB) {
        return narrow({firstCrosses4(a.low, slopeA.low, b.low, slopeB.low),
                       firstCrosses4(a.high, slopeA.high, b.high, slopeB.high)});
    }
    template <int minor, int axis>
    class Parts {
     public:
        explicit Parts(std::int32_t flip) : flip_(Ints{} + flip) {}
        Ints of(Ints cells) const { return addressPart<minor, axis>(cells, flip_); }

     private:
        Ints flip_;
    };

    static std::uint32_t markRow(FirstUnsettled* unsettled, const CellOffset* farthest,
                                 CellOffset offset, std::int32_t slice, std::uint32_t columns,
                                 std::uint32_t rows) {
        const Row row(unsettled, slice, columns, rows);
        // change = subBins != 0 && after != before
        const __m256i keep =
            _mm256_or_si256(_mm256_cmpeq_epi32(row.after, row.before),
                            _mm256_cmpeq_epi32(row.subBins, _mm256_setzero_si256()));
        unsigned change = ~signBits(keep) & 0xFF;
        if (change == 0) return 0;
        // ... && offset.within(farthest)
        const __m256i all = _mm256_set1_epi64x(static_cast<std::int64_t>(CellOffset::kAll));
        const __m256i far = _mm256_set1_epi64x(static_cast<std::int64_t>(offset.packed()));
        const auto within4 = [&](const CellOffset* four) {
            const __m256i room = _mm256_sub_epi64(_mm256_or_si256(load256(four), all), far);
            return static_cast<unsigned>(_mm256_movemask_pd(
                _mm256_castsi256_pd(_mm256_cmpeq_epi64(_mm256_and_si256(room, all), all))));
        };
        change &= within4(farthest) | within4(farthest + 4) << 4;
        if (change == 0) return 0;
        // unsettled = change ? after : before
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(unsettled),
                            (__m256i)select(maskOf(static_cast<int>(change)), (Ints)row.after,
                                            (Ints)row.before));
        return static_cast<std::uint32_t>(__builtin_popcount(change & row.full()));
    }

    /// The numbers of 8 rays: { first, first + 1, ... }.
    static UInts raysFrom(std::uint32_t first) { return first + UInts{0, 1, 2, 3, 4, 5, 6, 7}; }
    /// Bit i: ray i has the bin of the ray before it, which is not `none`.
    template <int kSubBinBits>
    static unsigned sameBins(const std::uint32_t* subBin, std::uint32_t none) {
        const __m256i bin = _mm256_srli_epi32(load256(subBin), kSubBinBits);
        const __m256i before = _mm256_srli_epi32(load256(subBin - 1), kSubBinBits);
        return signBits(_mm256_andnot_si256(
            _mm256_cmpeq_epi32(bin, _mm256_set1_epi32(static_cast<int>(none))),
            _mm256_cmpeq_epi32(bin, before)));
    }
    /// Bit i: ray i ends in the cell in which the ray before it ends.
    static unsigned sameOffsets(const CellOffset* offset) {
        const auto same4 = [](const CellOffset* at) {
            return static_cast<unsigned>(_mm256_movemask_pd(
                _mm256_castsi256_pd(_mm256_cmpeq_epi64(load256(at), load256(at - 1)))));
        };
        return same4(offset) | same4(offset + 4) << 4;
    }
    /// Bit i: ray i ends the way the ray before it does. Bits from `count` on: any.
    /// Reads `count` of them, no more.
    static unsigned sameEnds(const RayEnd* end, std::size_t count) {
        const auto load = [count](const RayEnd* at) {
            // With a constant, memcpy() is no call.
            std::uint64_t some = 0;
            if (count == 8)
                std::memcpy(&some, at, 8);
            else
                std::memcpy(&some, at, count);
            return _mm_cvtsi64_si128(static_cast<long long>(some));
        };
        return static_cast<unsigned>(
            _mm_movemask_epi8(_mm_cmpeq_epi8(load(end), load(end - 1))));
    }
};

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
