// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/compiler.h"
#include "kernels/walk_kernel.h"

#if defined(__x86_64__)
#include <immintrin.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#if defined(__clang__)  // which has no such preference
#define SUPERRAY_TARGET __attribute__((target("avx2,avx512f,avx512vl,avx512dq")))
#else
#define SUPERRAY_TARGET \
    __attribute__((target("avx2,avx512f,avx512vl,avx512dq,prefer-vector-width=512")))
#endif

#include "kernels/lane_types.h"
//
#include "kernels/mark_sub_bins.inc"

namespace superray {
namespace {

/// Low bits of Parts, see walk_vector.inc.
constexpr int kPickBits = 2;

namespace simd {

struct Long8 {
    __m512i v;
};

/// \pre 0 <= step < 2^32
SUPERRAY_TARGET inline Long8 ramp(std::int64_t base, std::int64_t step) {
    const __m512i lanes = _mm512_setr_epi64(0, 1, 2, 3, 4, 5, 6, 7);
    return {_mm512_add_epi64(_mm512_set1_epi64(base),
                             _mm512_mul_epu32(lanes, _mm512_set1_epi64(step)))};
}
SUPERRAY_TARGET inline Long8 all(std::int64_t x) {
    return {_mm512_set1_epi64(x)};
}
SUPERRAY_TARGET inline Long8 add(Long8 a, Long8 b) {
    return {_mm512_add_epi64(a.v, b.v)};
}
SUPERRAY_TARGET inline Long8 subtract(Long8 a, Long8 b) {
    return {_mm512_sub_epi64(a.v, b.v)};
}
SUPERRAY_TARGET inline __m256i cells(Long8 a) {
    return _mm512_cvtepi64_epi32(_mm512_srli_epi64(a.v, kUnitBits));
}
using Mask = int;
SUPERRAY_TARGET inline Mask maskOf(int bits) {
    return bits;
}
/// Lanes in which axis a crosses its next border before axis b: distances to
/// the border (at most 2^31) and slopes compare as exact products.
SUPERRAY_TARGET inline Mask firstCrosses(Long8 a, Long8 slopeA, Long8 b, Long8 slopeB) {
    const __m512i unit = _mm512_set1_epi64(kUnitsPerCell);
    const __m512i low = _mm512_set1_epi64(kUnitsPerCell - 1);
    const __m512i toA = _mm512_sub_epi64(unit, _mm512_and_si512(a.v, low));
    const __m512i toB = _mm512_sub_epi64(unit, _mm512_and_si512(b.v, low));
    return _mm512_cmplt_epi64_mask(_mm512_mul_epu32(toA, slopeB.v),
                                   _mm512_mul_epu32(toB, slopeA.v));
}
SUPERRAY_TARGET inline __m256i following(__m256i x, __m256i before) {
    return _mm256_alignr_epi32(x, before, 7);
}
SUPERRAY_TARGET inline int differing(__m256i a, __m256i b) {
    return _mm256_cmpneq_epi32_mask(a, b);
}
SUPERRAY_TARGET inline __m256i select(Mask mask, __m256i a, __m256i b) {
    return _mm256_mask_blend_epi32(static_cast<__mmask8>(mask), b, a);
}

/// Looked up in a table of 16.
template <int minor, int axis>
class Parts {
 public:
    SUPERRAY_TARGET explicit Parts(std::int32_t flip) {
        const __m256i cells = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        low_ = of(cells, flip);
        high_ = of(_mm256_add_epi32(cells, _mm256_set1_epi32(8)), flip);
    }
    SUPERRAY_TARGET __m256i of(__m256i cells) const {
        return _mm256_permutex2var_epi32(low_, cells, high_);
    }

 private:
    SUPERRAY_TARGET static __m256i of(__m256i cells, std::int32_t flip) {
        const __m256i local = _mm256_and_si256(_mm256_xor_si256(cells, _mm256_set1_epi32(flip)),
                                               _mm256_set1_epi32(7));
        const __m256i parity = _mm256_and_si256(cells, _mm256_set1_epi32(8));
        return _mm256_or_si256(_mm256_slli_epi32(local, kBlockBits * axis + kPickBits),
                               _mm256_srli_epi32(parity, kBlockBits - minor));
    }
    __m256i low_, high_;
};
SUPERRAY_TARGET inline std::uint32_t* compress(std::uint32_t* out, __m256i v, int mask) {
    // A register compress and a plain store: storing compressed is microcoded
    // on some processors.
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out),
                        _mm256_maskz_compress_epi32(static_cast<__mmask8>(mask), v));
    return out + __builtin_popcount(static_cast<unsigned>(mask));
}

SUPERRAY_TARGET inline std::uint32_t markRow(FirstUnsettled* unsettled,
                                             const CellOffset* farthest, CellOffset offset,
                                             std::int32_t slice, std::uint32_t columns,
                                             std::uint32_t rows) {
    const __m256i subBins = subBinsOfRow(columns, rows);
    const __m256i before = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(unsettled));
    const __m256i after = joined(before, subBins, slice);
    __mmask8 change =
        _mm256_mask_cmpneq_epi32_mask(_mm256_test_epi32_mask(subBins, subBins), after, before);
    if (change == 0) return 0;
    const __m512i all = _mm512_set1_epi64(static_cast<std::int64_t>(CellOffset::kAll));
    const __m512i room =
        _mm512_sub_epi64(_mm512_or_si512(_mm512_loadu_si512(farthest), all),
                         _mm512_set1_epi64(static_cast<std::int64_t>(offset.packed())));
    change = _mm512_mask_cmpeq_epi64_mask(change, _mm512_and_si512(room, all), all);
    _mm256_mask_storeu_epi32(unsettled, change, after);
    const auto full =
        static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(allSubBins(after))));
    return static_cast<std::uint32_t>(__builtin_popcount(change & full));
}
SUPERRAY_TARGET inline __m256i gatherInts(const int* base, __m256i indices) {
    return _mm256_i32gather_epi32(base, indices, 4);
}
struct Double8 {
    __m512d v;
};

SUPERRAY_TARGET inline Double8 gatherDoubles(const double* base, const std::uint32_t* indices) {
    return {_mm512_i64gather_pd(
        _mm512_cvtepu32_epi64(_mm256_load_si256(reinterpret_cast<const __m256i*>(indices))),
        base, 8)};
}
SUPERRAY_TARGET inline Double8 gatherDoubles(const float* base, const std::uint32_t* indices) {
    return {_mm512_cvtps_pd(_mm256_i32gather_ps(
        base, _mm256_load_si256(reinterpret_cast<const __m256i*>(indices)), 4))};
}
SUPERRAY_TARGET inline Double8 times(Double8 a, double x) {
    return {a.v * x};
}
SUPERRAY_TARGET inline Double8 over(Double8 a, Double8 b) {
    return {a.v / b.v};
}
SUPERRAY_TARGET inline Long8 floorOf(Double8 x) {
    return {_mm512_cvt_roundpd_epi64(x.v, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC)};
}
SUPERRAY_TARGET inline Double8 toDouble(Long8 i) {
    return {_mm512_cvtepi64_pd(i.v)};
}
SUPERRAY_TARGET inline Long8 product(Long8 a, Long8 b) {
    return {_mm512_mul_epu32(a.v, b.v)};
}
SUPERRAY_TARGET inline Long8 wholeUnits(Long8 a) {
    return {_mm512_srli_epi64(a.v, kUnitBits)};
}
SUPERRAY_TARGET inline Long8 wide(__m256i x) {
    return {_mm512_cvtepi32_epi64(x)};
}
SUPERRAY_TARGET inline void store(Long8 a, std::int64_t* to) {
    _mm512_storeu_si512(to, a.v);
}

}  // namespace simd
}  // namespace
}  // namespace superray

// In this order: the later ones use the earlier.
#include "kernels/walk_vector.inc"
//
#include "kernels/walk_rays.inc"
//
#include "kernels/walk_ends.inc"
//
#define SUPERRAY_ROUNDS
#include "kernels/classify_rays.inc"
//
#define SUPERRAY_POINT_BYTES 64
#include "kernels/copy_points.inc"
//
#include "kernels/at_least.inc"
//
#include "kernels/mark_boundary.inc"

namespace superray {
namespace {

template <int Dim>
SUPERRAY_TARGET std::size_t findRuns(const ClassifiedBatch<Dim>& directions, const RayEnd* ends,
                                     std::size_t count, std::uint32_t* starts) {
    const std::uint32_t* const subBins = directions.subBin;
    const auto binsFrom = [&](std::size_t at) SUPERRAY_TARGET {
        return _mm512_srli_epi32(_mm512_loadu_si512(subBins + at),
                                 DirectionBins<Dim>::kSubBinBits);
    };
    const CellOffset* const endOffsets = directions.endOffset.data();
    const __m512i unclassified = _mm512_set1_epi32(static_cast<int>(directions.unclassified));
    __m512i ray = _mm512_setr_epi32(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16);
    starts[0] = 0;
    std::size_t runs = 1;
    for (std::size_t i = 1; i < count; i += 16) {
        const __m512i bin = binsFrom(i);
        const auto differing64 = [&](std::size_t at) SUPERRAY_TARGET {
            return static_cast<unsigned>(_mm512_cmpneq_epi64_mask(
                _mm512_loadu_si512(endOffsets + at), _mm512_loadu_si512(endOffsets + at - 1)));
        };
        const std::size_t n = std::min<std::size_t>(16, count - i);
        const auto endsFrom = [&](std::size_t at) SUPERRAY_TARGET {
            if (n == 16) return _mm_loadu_si128(reinterpret_cast<const __m128i*>(ends + at));
            // There is nothing beyond the last ray that could be loaded.
            alignas(16) RayEnd some[16] = {};
            std::memcpy(some, ends + at, n);
            return _mm_load_si128(reinterpret_cast<const __m128i*>(some));
        };
        const __m128i same = _mm_cmpeq_epi8(endsFrom(i), endsFrom(i - 1));
        unsigned fresh = _mm512_cmpneq_epi32_mask(bin, binsFrom(i - 1)) |
                         _mm512_cmpeq_epi32_mask(bin, unclassified) | differing64(i) |
                         differing64(i + 8) << 8 |
                         (~static_cast<unsigned>(_mm_movemask_epi8(same)) & 0xFFFF);
        fresh &= (1u << n) - 1;
        _mm512_storeu_si512(starts + runs,
                            _mm512_maskz_compress_epi32(static_cast<__mmask16>(fresh), ray));
        runs += static_cast<std::size_t>(__builtin_popcount(fresh));
        ray = _mm512_add_epi32(ray, _mm512_set1_epi32(16));
    }
    return runs;
}

SUPERRAY_TARGET std::size_t chooseRays(const std::uint32_t* subBin,
                                       const std::uint16_t* lastSlice, std::size_t count,
                                       const FirstUnsettled* unsettled, std::uint32_t* chosen) {
    constexpr int kSubBinBits = DirectionBins<3>::kSubBinBits;
    __m512i ray = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    std::size_t n = 0;
    for (std::size_t i = 0; i < count; i += 16) {
        const auto asked =
            static_cast<__mmask16>(count - i < 16 ? (1u << (count - i)) - 1 : 0xFFFFu);
        const __m512i at = _mm512_maskz_loadu_epi32(asked, subBin + i);
        const __m512i found = _mm512_mask_i32gather_epi32(
            _mm512_setzero_si512(), asked, _mm512_srli_epi32(at, kSubBinBits), unsettled, 4);
        const __m512i inBin =
            _mm512_and_si512(at, _mm512_set1_epi32(FirstUnsettled::kSubBins - 1));
        const __mmask16 marked = _mm512_mask_test_epi32_mask(
            asked, _mm512_srlv_epi32(found, inBin), _mm512_set1_epi32(1));
        const __m512i first = _mm512_srli_epi32(found, FirstUnsettled::kSubBins);
        const __m512i last = _mm512_cvtepu16_epi32(
            _mm256_loadu_si256(reinterpret_cast<const __m256i*>(lastSlice + i)));
        const __mmask16 mask = _mm512_mask_cmple_epi32_mask(marked, first, last);
        _mm512_storeu_si512(chosen + n, _mm512_maskz_compress_epi32(mask, ray));
        n += static_cast<std::size_t>(__builtin_popcount(mask));
        ray = _mm512_add_epi32(ray, _mm512_set1_epi32(16));
    }
    return n;
}

}  // namespace

template <int Dim>
WalkKernels<Dim> avx512Kernels() {
    return {walkLine<Dim>,          walkRays<Dim>,     walkEnds<Dim>,
            classifyRays<Dim>,      findRuns<Dim>,     chooseRays,
            atLeast<Dim>,           markBoundary<Dim>, copyPoints<Dim, float>,
            copyPoints<Dim, double>};
}

template WalkKernels<2> avx512Kernels();
template WalkKernels<3> avx512Kernels();

}  // namespace superray
#endif
