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

#define SUPERRAY_TARGET __attribute__((target("avx2")))

#include "kernels/lane_types.h"
//
#include "kernels/mark_sub_bins.inc"

namespace superray {
namespace {

/// Low bits of Parts, see walk_vector.inc.
constexpr int kPickBits = 2;

namespace simd {

/// Lanes 0, 1, 4, 5 are `low`, the others `high`: so the halves of 256-bit vectors need
/// not be crossed to make one of 32-bit lanes of both.
struct Long8 {
    __m256i low, high;
};

/// \pre 0 <= step < 2^32
SUPERRAY_TARGET inline Long8 ramp(std::int64_t base, std::int64_t step) {
    const __m256i start = _mm256_set1_epi64x(base), each = _mm256_set1_epi64x(step);
    return {_mm256_add_epi64(start, _mm256_mul_epu32(each, _mm256_setr_epi64x(0, 1, 4, 5))),
            _mm256_add_epi64(start, _mm256_mul_epu32(each, _mm256_setr_epi64x(2, 3, 6, 7)))};
}
SUPERRAY_TARGET inline Long8 all(std::int64_t x) {
    return {_mm256_set1_epi64x(x), _mm256_set1_epi64x(x)};
}
SUPERRAY_TARGET inline Long8 add(Long8 a, Long8 b) {
    return {_mm256_add_epi64(a.low, b.low), _mm256_add_epi64(a.high, b.high)};
}
SUPERRAY_TARGET inline Long8 subtract(Long8 a, Long8 b) {
    return {_mm256_sub_epi64(a.low, b.low), _mm256_sub_epi64(a.high, b.high)};
}
/// The low halves of 8 int64.
SUPERRAY_TARGET inline __m256i narrow(Long8 a) {
    return _mm256_castps_si256(
        _mm256_shuffle_ps(_mm256_castsi256_ps(a.low), _mm256_castsi256_ps(a.high), 0x88));
}
SUPERRAY_TARGET inline __m256i cells(Long8 a) {
    // A logical shift will do: the sign is in the 32 bits that are kept.
    return narrow({_mm256_srli_epi64(a.low, kUnitBits), _mm256_srli_epi64(a.high, kUnitBits)});
}
SUPERRAY_TARGET inline __m256i distanceToBorder(__m256i units) {
    return _mm256_sub_epi64(_mm256_set1_epi64x(kUnitsPerCell),
                            _mm256_and_si256(units, _mm256_set1_epi64x(kUnitsPerCell - 1)));
}
/// All bits of the lanes that are meant.
using Mask = __m256i;
SUPERRAY_TARGET inline Mask maskOf(int bits) {
    const __m256i each = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(bits), each), each);
}
SUPERRAY_TARGET inline __m256i firstCrosses4(__m256i a, __m256i slopeA, __m256i b,
                                             __m256i slopeB) {
    return _mm256_cmpgt_epi64(_mm256_mul_epu32(distanceToBorder(b), slopeA),
                              _mm256_mul_epu32(distanceToBorder(a), slopeB));
}
/// Lanes in which axis a crosses its next border before axis b: distances to
/// the border (at most 2^31) and slopes compare as exact products.
SUPERRAY_TARGET inline Mask firstCrosses(Long8 a, Long8 slopeA, Long8 b, Long8 slopeB) {
    return narrow({firstCrosses4(a.low, slopeA.low, b.low, slopeB.low),
                   firstCrosses4(a.high, slopeA.high, b.high, slopeB.high)});
}
SUPERRAY_TARGET inline __m256i following(__m256i x, __m256i before) {
    return _mm256_alignr_epi8(x, _mm256_permute2x128_si256(before, x, 0x21), 12);
}
SUPERRAY_TARGET inline int differing(__m256i a, __m256i b) {
    return ~_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b))) & 0xFF;
}
SUPERRAY_TARGET inline __m256i select(Mask mask, __m256i a, __m256i b) {
    return _mm256_castps_si256(_mm256_blendv_ps(_mm256_castsi256_ps(b), _mm256_castsi256_ps(a),
                                                _mm256_castsi256_ps(mask)));
}

template <int minor, int axis>
class Parts {
 public:
    SUPERRAY_TARGET explicit Parts(std::int32_t flip) : flip_(_mm256_set1_epi32(flip)) {}
    SUPERRAY_TARGET __m256i of(__m256i cells) const {
        const __m256i plain = _mm256_xor_si256(cells, flip_);
        const __m256i local = _mm256_and_si256(plain, _mm256_set1_epi32(7));
        const __m256i parity = _mm256_and_si256(cells, _mm256_set1_epi32(8));
        return _mm256_or_si256(_mm256_slli_epi32(local, kBlockBits * axis + kPickBits),
                               _mm256_srli_epi32(parity, kBlockBits - minor));
    }

 private:
    __m256i flip_;
};

/// Per mask: the lanes in it, in order, as a permutation.
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

SUPERRAY_TARGET inline std::uint32_t* compress(std::uint32_t* out, __m256i v, int mask) {
    const __m256i order =
        _mm256_load_si256(reinterpret_cast<const __m256i*>(kCompress.lanes[mask]));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), _mm256_permutevar8x32_epi32(v, order));
    return out + __builtin_popcount(static_cast<unsigned>(mask));
}

SUPERRAY_TARGET inline std::uint32_t markRow(FirstUnsettled* unsettled,
                                             const CellOffset* farthest, CellOffset offset,
                                             std::int32_t slice, std::uint32_t columns,
                                             std::uint32_t rows) {
    const __m256i subBins = subBinsOfRow(columns, rows);
    const __m256i before = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(unsettled));
    const __m256i after = joined(before, subBins, slice);
    const __m256i keep = _mm256_or_si256(_mm256_cmpeq_epi32(after, before),
                                         _mm256_cmpeq_epi32(subBins, _mm256_setzero_si256()));
    unsigned change =
        ~static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(keep))) & 0xFF;
    if (change == 0) return 0;
    const __m256i all = _mm256_set1_epi64x(static_cast<std::int64_t>(CellOffset::kAll));
    const __m256i far = _mm256_set1_epi64x(static_cast<std::int64_t>(offset.packed()));
    const auto reached = [&](int half) SUPERRAY_TARGET {
        const __m256i room = _mm256_sub_epi64(
            _mm256_or_si256(
                _mm256_loadu_si256(reinterpret_cast<const __m256i*>(farthest) + half), all),
            far);
        return static_cast<unsigned>(_mm256_movemask_pd(
            _mm256_castsi256_pd(_mm256_cmpeq_epi64(_mm256_and_si256(room, all), all))));
    };
    change &= reached(0) | reached(1) << 4;
    if (change == 0) return 0;
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(unsettled),
                        select(maskOf(static_cast<int>(change)), after, before));
    const auto full =
        static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(allSubBins(after))));
    return static_cast<std::uint32_t>(__builtin_popcount(change & full));
}
SUPERRAY_TARGET inline __m256i gatherInts(const int* base, __m256i indices) {
    return _mm256_i32gather_epi32(base, indices, 4);
}
struct Double8 {  // as Long8
    __m256d low, high;
};

template <typename Scalar>
SUPERRAY_TARGET inline Double8 gatherDoubles(const Scalar* base, const std::uint32_t* indices) {
    const auto at = [&](int i) SUPERRAY_TARGET { return double{base[indices[i]]}; };
    return {_mm256_setr_pd(at(0), at(1), at(4), at(5)),
            _mm256_setr_pd(at(2), at(3), at(6), at(7))};
}
SUPERRAY_TARGET inline Double8 times(Double8 a, double x) {
    return {a.low * x, a.high * x};
}
SUPERRAY_TARGET inline Double8 over(Double8 a, Double8 b) {
    return {a.low / b.low, a.high / b.high};
}
/// Adding this leaves an integer in the low bits of the sum.
constexpr double kRounder = 6755399441055744.0;  // 1.5 * 2^52
SUPERRAY_TARGET inline __m256i floorOf(__m256d x) {
    const __m256d rounder = _mm256_set1_pd(kRounder);
    return _mm256_sub_epi64(_mm256_castpd_si256(_mm256_floor_pd(x) + rounder),
                            _mm256_castpd_si256(rounder));
}
SUPERRAY_TARGET inline Long8 floorOf(Double8 x) {
    return {floorOf(x.low), floorOf(x.high)};
}
SUPERRAY_TARGET inline __m256d toDouble(__m256i i) {
    const __m256d great = _mm256_set1_pd(4503599627370496.0);  // 2^52
    return _mm256_castsi256_pd(_mm256_or_si256(i, _mm256_castpd_si256(great))) - great;
}
SUPERRAY_TARGET inline Double8 toDouble(Long8 i) {
    return {toDouble(i.low), toDouble(i.high)};
}
SUPERRAY_TARGET inline Long8 product(Long8 a, Long8 b) {
    return {_mm256_mul_epu32(a.low, b.low), _mm256_mul_epu32(a.high, b.high)};
}
SUPERRAY_TARGET inline Long8 wholeUnits(Long8 a) {
    return {_mm256_srli_epi64(a.low, kUnitBits), _mm256_srli_epi64(a.high, kUnitBits)};
}
SUPERRAY_TARGET inline Long8 wide(__m256i x) {
    return {_mm256_unpacklo_epi32(x, _mm256_setzero_si256()),
            _mm256_unpackhi_epi32(x, _mm256_setzero_si256())};
}
SUPERRAY_TARGET inline void store(Long8 a, std::int64_t* to) {
    const auto lanes = reinterpret_cast<__m256i*>(to);
    _mm256_storeu_si256(lanes, _mm256_permute2x128_si256(a.low, a.high, 0x20));
    _mm256_storeu_si256(lanes + 1, _mm256_permute2x128_si256(a.low, a.high, 0x31));
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
#include "kernels/choose_rays.inc"
//
#define SUPERRAY_POINT_BYTES 32
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
    const CellOffset* const endOffsets = directions.endOffset.data();
    const __m256i unclassified = _mm256_set1_epi32(static_cast<int>(directions.unclassified));
    const auto load = [](const auto* from) SUPERRAY_TARGET {
        return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
    };
    const auto binsFrom = [&](std::size_t at) SUPERRAY_TARGET {
        return _mm256_srli_epi32(load(subBins + at), DirectionBins<Dim>::kSubBinBits);
    };
    const auto equal64 = [&](std::size_t at) SUPERRAY_TARGET {
        return static_cast<unsigned>(_mm256_movemask_pd(_mm256_castsi256_pd(
            _mm256_cmpeq_epi64(load(endOffsets + at), load(endOffsets + at - 1)))));
    };
    __m256i ray = _mm256_setr_epi32(1, 2, 3, 4, 5, 6, 7, 8);
    starts[0] = 0;
    std::uint32_t* out = starts + 1;
    for (std::size_t i = 1; i < count; i += 8) {
        const __m256i bin = binsFrom(i);
        const std::size_t n = std::min<std::size_t>(8, count - i);
        const auto endsFrom = [&](std::size_t at) SUPERRAY_TARGET {
            // There is nothing beyond the last ray that could be loaded. With a constant,
            // memcpy() is no call.
            std::uint64_t some = 0;
            if (n == 8)
                std::memcpy(&some, ends + at, 8);
            else
                std::memcpy(&some, ends + at, n);
            return _mm_cvtsi64_si128(static_cast<long long>(some));
        };
        const __m128i sameEnd = _mm_cmpeq_epi8(endsFrom(i), endsFrom(i - 1));
        const __m256i sameBin = _mm256_andnot_si256(_mm256_cmpeq_epi32(bin, unclassified),
                                                    _mm256_cmpeq_epi32(bin, binsFrom(i - 1)));
        const unsigned same =
            static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(sameBin))) &
            (equal64(i) | equal64(i + 4) << 4) &
            static_cast<unsigned>(_mm_movemask_epi8(sameEnd));
        out = simd::compress(out, ray, static_cast<int>(~same & ((1u << n) - 1)));
        ray = _mm256_add_epi32(ray, _mm256_set1_epi32(8));
    }
    return static_cast<std::size_t>(out - starts);
}

}  // namespace

template <int Dim>
WalkKernels<Dim> avx2Kernels() {
    return {walkLine<Dim>,          walkRays<Dim>,     walkEnds<Dim>,
            classifyRays<Dim>,      findRuns<Dim>,     chooseRays,
            atLeast<Dim>,           markBoundary<Dim>, copyPoints<Dim, float>,
            copyPoints<Dim, double>};
}

template WalkKernels<2> avx2Kernels();
template WalkKernels<3> avx2Kernels();

}  // namespace superray
#endif
