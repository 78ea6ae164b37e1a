// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Vector code for AVX-512 (F, VL, DQ, BW): registers of 512 bits, sets of lanes
// as bits. For the meaning of the operations see Portable.

#include <superray/core/ray_bundle.h>
#include <superray/core/ray_line.h>

#include "directions/classified_batch.h"
#include "kernels/simd/avx_common.h"

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

struct Avx512 : AvxCommon {
    using Floats = float __attribute__((vector_size(64)));
    using Doubles = double __attribute__((vector_size(64)));
    static constexpr int kRunLanes = 16, kChoiceLanes = 16;

    struct Long8 {
        __m512i v;
        Long8 operator+(Long8 o) const { return {_mm512_add_epi64(v, o.v)}; }
        Long8 operator-(Long8 o) const { return {_mm512_sub_epi64(v, o.v)}; }
    };
    struct Double8 {
        __m512d v;
    };
    using Mask = int;

    static Long8 ramp(std::int64_t base, std::int64_t step) {
        const __m512i lanes = _mm512_setr_epi64(0, 1, 2, 3, 4, 5, 6, 7);
        return {_mm512_add_epi64(_mm512_set1_epi64(base),
                                 _mm512_mul_epu32(lanes, _mm512_set1_epi64(step)))};
    }
    static Long8 all(std::int64_t x) { return {_mm512_set1_epi64(x)}; }
    /// A logical shift will do: the sign is in the 32 bits that are kept.
    static Ints cells(Long8 units) { return (Ints)_mm512_cvtepi64_epi32(wholeUnits(units).v); }
    static Long8 wholeUnits(Long8 a) { return {_mm512_srli_epi64(a.v, kUnitBits)}; }
    static Long8 product(Long8 a, Long8 b) { return {_mm512_mul_epu32(a.v, b.v)}; }
    static Long8 wide(Ints x) { return {_mm512_cvtepi32_epi64((__m256i)x)}; }
    static void store(Long8 a, std::int64_t* to) { _mm512_storeu_si512(to, a.v); }

    static Double8 gatherDoubles(const double* base, const std::uint32_t* indices) {
        return {_mm512_i64gather_pd(_mm512_cvtepu32_epi64(load256(indices)), base, 8)};
    }
    static Double8 gatherDoubles(const float* base, const std::uint32_t* indices) {
        return {_mm512_cvtps_pd(_mm256_i32gather_ps(base, load256(indices), 4))};
    }
    static Double8 times(Double8 a, double x) { return {a.v * x}; }
    static Double8 over(Double8 a, Double8 b) { return {a.v / b.v}; }
    static Long8 floorOf(Double8 x) {
        return {_mm512_cvt_roundpd_epi64(x.v, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC)};
    }
    static Double8 toDouble(Long8 i) { return {_mm512_cvtepi64_pd(i.v)}; }

    static Mask maskOf(int bits) { return bits; }
    static int differing(Ints a, Ints b) {
        return _mm256_cmpneq_epi32_mask((__m256i)a, (__m256i)b);
    }
    static Ints select(Mask mask, Ints a, Ints b) {
        return (Ints)_mm256_mask_blend_epi32(static_cast<__mmask8>(mask), (__m256i)b,
                                             (__m256i)a);
    }
    static Ints following(Ints x, Ints before) {
        return (Ints)_mm256_alignr_epi32((__m256i)x, (__m256i)before, 7);
    }
    /// A register compress and a plain store: storing compressed is microcoded on
    /// some processors.
    static std::uint32_t* compress(std::uint32_t* out, UInts v, int mask) {
        _mm256_storeu_si256(
            reinterpret_cast<__m256i*>(out),
            _mm256_maskz_compress_epi32(static_cast<__mmask8>(mask), (__m256i)v));
        return out + __builtin_popcount(static_cast<unsigned>(mask));
    }
    using UInts16 = std::uint32_t __attribute__((vector_size(64)));
    /// The same of 16 lanes.
    static std::uint32_t* compress(std::uint32_t* out, UInts16 v, unsigned mask) {
        _mm512_storeu_si512(
            out, _mm512_maskz_compress_epi32(static_cast<__mmask16>(mask), (__m512i)v));
        return out + __builtin_popcount(mask);
    }

    static __m512i toBorder(__m512i units) {
        return _mm512_sub_epi64(_mm512_set1_epi64(kUnitsPerCell),
                                _mm512_and_si512(units, _mm512_set1_epi64(kUnitsPerCell - 1)));
    }
    static Mask firstCrosses(Long8 a, Long8 slopeA, Long8 b, Long8 slopeB) {
        return _mm512_cmplt_epi64_mask(_mm512_mul_epu32(toBorder(a.v), slopeB.v),
                                       _mm512_mul_epu32(toBorder(b.v), slopeA.v));
    }
    /// addressPart() depends on 4 bits of the cell: looked up in a table of 16.
    template <int minor, int axis>
    class Parts {
     public:
        explicit Parts(std::int32_t flip) {
            const Ints cells = {0, 1, 2, 3, 4, 5, 6, 7};
            low_ = (__m256i)addressPart<minor, axis>(cells, Ints{} + flip);
            high_ = (__m256i)addressPart<minor, axis>(cells + 8, Ints{} + flip);
        }
        Ints of(Ints cells) const {
            return (Ints)_mm256_permutex2var_epi32(low_, (__m256i)cells, high_);
        }

     private:
        __m256i low_, high_;
    };

    static std::uint32_t markRow(FirstUnsettled* unsettled, const CellOffset* farthest,
                                 CellOffset offset, std::int32_t slice, std::uint32_t columns,
                                 std::uint32_t rows) {
        const Row row(unsettled, slice, columns, rows);
        // change = subBins != 0 && after != before
        __mmask8 change = _mm256_mask_cmpneq_epi32_mask(
            _mm256_test_epi32_mask(row.subBins, row.subBins), row.after, row.before);
        if (change == 0) return 0;
        // ... && offset.within(farthest)
        const __m512i all = _mm512_set1_epi64(static_cast<std::int64_t>(CellOffset::kAll));
        const __m512i room =
            _mm512_sub_epi64(_mm512_or_si512(_mm512_loadu_si512(farthest), all),
                             _mm512_set1_epi64(static_cast<std::int64_t>(offset.packed())));
        change = _mm512_mask_cmpeq_epi64_mask(change, _mm512_and_si512(room, all), all);
        // if (change) unsettled = after
        _mm256_mask_storeu_epi32(unsettled, change, row.after);
        return static_cast<std::uint32_t>(__builtin_popcount(change & row.full()));
    }

    /// The numbers of 16 rays: { first, first + 1, ... }.
    static UInts16 raysFrom(std::uint32_t first) {
        return first + UInts16{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    }
    /// Bit i: ray i has the bin of the ray before it, which is not `none`.
    template <int kSubBinBits>
    static unsigned sameBins(const std::uint32_t* subBin, std::uint32_t none) {
        const __m512i bin = _mm512_srli_epi32(_mm512_loadu_si512(subBin), kSubBinBits);
        const __m512i before = _mm512_srli_epi32(_mm512_loadu_si512(subBin - 1), kSubBinBits);
        return _mm512_mask_cmpneq_epi32_mask(_mm512_cmpeq_epi32_mask(bin, before), bin,
                                             _mm512_set1_epi32(static_cast<int>(none)));
    }
    /// Bit i: ray i ends in the cell in which the ray before it ends.
    static unsigned sameOffsets(const CellOffset* offset) {
        const auto same8 = [](const CellOffset* at) {
            return static_cast<unsigned>(
                _mm512_cmpeq_epi64_mask(_mm512_loadu_si512(at), _mm512_loadu_si512(at - 1)));
        };
        return same8(offset) | same8(offset + 8) << 8;
    }
    /// Bit i: ray i ends the way the ray before it does. Bits from `count` on: any.
    /// Reads `count` of them, no more.
    static unsigned sameEnds(const RayEnd* end, std::size_t count) {
        const auto load = [count](const RayEnd* at) {
            if (count == 16) return _mm_loadu_si128(reinterpret_cast<const __m128i*>(at));
            alignas(16) RayEnd some[16] = {};
            std::memcpy(some, at, count);
            return _mm_load_si128(reinterpret_cast<const __m128i*>(some));
        };
        return static_cast<unsigned>(
            _mm_movemask_epi8(_mm_cmpeq_epi8(load(end), load(end - 1))));
    }
    /// Bit i: ray i may change the map, as ChooseRays says. Reads subBin[i] of
    /// the first `count` rays only.
    template <int kSubBinBits>
    static unsigned choosable(const std::uint32_t* subBin, const std::uint16_t* lastSlice,
                              std::size_t count, const FirstUnsettled* unsettled) {
        const auto asked = static_cast<__mmask16>(count < 16 ? (1u << count) - 1 : 0xFFFFu);
        const __m512i at = _mm512_maskz_loadu_epi32(asked, subBin);
        // first = unsettled[subBin / 16]
        const __m512i first = _mm512_mask_i32gather_epi32(
            _mm512_setzero_si512(), asked, _mm512_srli_epi32(at, kSubBinBits), unsettled, 4);
        // contains = first.word >> subBin % 16 & 1
        const __m512i inBin =
            _mm512_and_si512(at, _mm512_set1_epi32(FirstUnsettled::kSubBins - 1));
        const __mmask16 contains = _mm512_mask_test_epi32_mask(
            asked, _mm512_srlv_epi32(first, inBin), _mm512_set1_epi32(1));
        // contains && first.slice() <= lastSlice
        const __m512i slice = _mm512_srli_epi32(first, FirstUnsettled::kSubBins);
        return _mm512_mask_cmple_epi32_mask(contains, slice,
                                            _mm512_cvtepu16_epi32(load256(lastSlice)));
    }
};

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
