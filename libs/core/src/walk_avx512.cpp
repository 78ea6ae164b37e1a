#include "walk_kernel.h"

#include "point_kernels.h"

#if defined(__x86_64__)
#include <immintrin.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>

#define SUPERRAY_TARGET \
    __attribute__((target("avx2,avx512f,avx512vl,avx512dq,prefer-vector-width=512")))

#include "lane_types.h"

namespace superray {
namespace {

/// Low bits of Parts, see walk_vector.inc.
constexpr int kPickBits = 2;

namespace simd {

struct Long8 {
    __m512i v;
};

SUPERRAY_TARGET inline Long8 ramp(std::int64_t base, std::int64_t step) {
    const __m512i lanes = _mm512_setr_epi64(0, 1, 2, 3, 4, 5, 6, 7);
    return {_mm512_add_epi64(_mm512_set1_epi64(base),
                             _mm512_mullo_epi64(lanes, _mm512_set1_epi64(step)))};
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
/// Lanes in which axis a crosses its next border before axis b: distances to
/// the border (at most 2^31) and slopes compare as exact products.
SUPERRAY_TARGET inline int firstCrosses(Long8 a, Long8 slopeA, Long8 b, Long8 slopeB) {
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
SUPERRAY_TARGET inline __m256i select(int mask, __m256i a, __m256i b) {
    return _mm256_mask_blend_epi32(static_cast<__mmask8>(mask), b, a);
}

/// Looked up in a table of 16.
template <int minor, int axis>
class Parts {
 public:
    SUPERRAY_TARGET explicit Parts(std::int32_t flip) {
        const __m256i cells = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        low_ = plain(_mm256_xor_si256(cells, _mm256_set1_epi32(flip)));
        high_ = plain(_mm256_xor_si256(_mm256_add_epi32(cells, _mm256_set1_epi32(8)),
                                       _mm256_set1_epi32(flip)));
    }
    SUPERRAY_TARGET __m256i of(__m256i cells) const {
        return _mm256_permutex2var_epi32(low_, cells, high_);
    }

 private:
    SUPERRAY_TARGET static __m256i plain(__m256i cells) {
        const __m256i local = _mm256_and_si256(cells, _mm256_set1_epi32(7));
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

SUPERRAY_TARGET inline Doubles gatherDoubles(const double* base, const std::uint32_t* indices) {
    return (Doubles)_mm512_i64gather_pd(
        _mm512_cvtepu32_epi64(_mm256_load_si256(reinterpret_cast<const __m256i*>(indices))),
        base, 8);
}

}  // namespace simd
}  // namespace
}  // namespace superray

// In this order: the later ones use the earlier.
#include "walk_vector.inc"
//
#include "walk_rays.inc"
//
#include "find_directions.inc"
//
#define SUPERRAY_POINT_LANES 16
#include "copy_points.inc"
//
#include "at_least.inc"

namespace superray {

template <int Dim>
WalkKernels<Dim> avx512Kernels() {
    return {walkLine<Dim>, walkRays<Dim>, findDirections<Dim>, atLeast<Dim>};
}

template <int Dim>
PointKernels<Dim> avx512PointKernels() {
    return {copyPoints<Dim, float>, copyPoints<Dim, double>};
}

template WalkKernels<2> avx512Kernels();
template WalkKernels<3> avx512Kernels();
template PointKernels<2> avx512PointKernels();
template PointKernels<3> avx512PointKernels();

}  // namespace superray
#endif
