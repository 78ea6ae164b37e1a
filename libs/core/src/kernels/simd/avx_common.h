// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What AVX2 and AVX-512 do alike with 8 lanes of 32 bits. For the meaning of
// the operations see Portable.

#include <immintrin.h>

#include "directions/first_unsettled.h"
#include "kernels/simd/address_part.h"

#include <cstring>

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

struct AvxCommon {
    static constexpr bool kWalksLanes = true;
    static constexpr bool kHasFloor = true;

    static __m256i load256(const void* from) {
        return _mm256_loadu_si256(static_cast<const __m256i*>(from));
    }
    /// Bit i: the sign bit of lane i.
    static unsigned signBits(__m256i lanes) {
        return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(lanes)));
    }
    static int bitsOf(Ints mask) { return static_cast<int>(signBits((__m256i)mask)); }

    static UInts pickOf4(UInts table, UInts sum) {
        return (UInts)_mm256_castps_si256(
            _mm256_permutevar_ps(_mm256_castsi256_ps((__m256i)table), (__m256i)sum));
    }
    static UInts twice(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        return (UInts)_mm256_broadcastsi128_si256(
            _mm_setr_epi32(static_cast<int>(a), static_cast<int>(b), static_cast<int>(c),
                           static_cast<int>(d)));
    }
    static Ints gatherInts(const std::int32_t* base, Ints indices) {
        return (Ints)_mm256_i32gather_epi32(base, (__m256i)indices, 4);
    }

    static std::uint64_t atLeast64(const std::uint8_t* counts, std::uint32_t least) {
        const __m256i needed = _mm256_set1_epi8(static_cast<char>(least));
        // counts[i] >= least: max(counts[i], least) == counts[i]
        const auto atLeast32 = [&](const std::uint8_t* from) {
            const __m256i c = load256(from);
            return static_cast<std::uint32_t>(
                _mm256_movemask_epi8(_mm256_cmpeq_epi8(_mm256_max_epu8(c, needed), c)));
        };
        return atLeast32(counts) | std::uint64_t{atLeast32(counts + 32)} << 32;
    }

    /// The steps of markRow(), for 8 bins.
    struct Row {
        __m256i subBins, before, after;

        Row(const FirstUnsettled* unsettled, std::int32_t slice, std::uint32_t columns,
            std::uint32_t rows) {
            // subBins[i] = (columns >> 4 * i & 15) * rows
            const __m256i perBin = _mm256_and_si256(
                _mm256_srlv_epi32(_mm256_set1_epi32(static_cast<int>(columns)),
                                  _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28)),
                _mm256_set1_epi32(15));
            subBins = _mm256_mullo_epi16(perBin, _mm256_set1_epi32(static_cast<int>(rows)));
            before = load256(unsettled);
            // after[i] = before[i].joined(FirstUnsettled::of(slice, subBins[i])): the
            // high half is the lesser slice, the low half the sub-bins of both
            const __m256i latest = _mm256_set1_epi32(
                static_cast<int>(FirstUnsettled::all(static_cast<Slice>(slice)).word));
            after = _mm256_blend_epi16(_mm256_min_epu32(before, latest),
                                       _mm256_or_si256(before, subBins), 0x55);
        }
        /// Bit i: all sub-bins of bin i are unsettled.
        unsigned full() const {
            const __m256i slices =
                _mm256_set1_epi32(static_cast<int>(~FirstUnsettled::kAllSubBins));
            return signBits(
                _mm256_cmpeq_epi32(_mm256_or_si256(after, slices), _mm256_set1_epi32(-1)));
        }
    };
};

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
