#include "walk_kernel.h"

#if defined(__x86_64__)
#include <immintrin.h>

#include <algorithm>
#include <cstring>

#define SUPERRAY_TARGET \
    __attribute__((target("avx2,avx512f,avx512vl,avx512dq,prefer-vector-width=512")))

#include "lane_types.h"

namespace superray {
namespace {
namespace simd {

struct Long8 {
    __m512i v;
};

SUPERRAY_TARGET inline Long8 ramp(std::int64_t base, std::int64_t step) {
    const __m512i lanes = _mm512_setr_epi64(0, 1, 2, 3, 4, 5, 6, 7);
    return {_mm512_add_epi64(_mm512_set1_epi64(base),
                             _mm512_mullo_epi64(lanes, _mm512_set1_epi64(step)))};
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
SUPERRAY_TARGET inline __m256i expand(int mask) {
    return _mm256_movm_epi32(static_cast<__mmask8>(mask));
}
SUPERRAY_TARGET inline std::uint32_t* compress(std::uint32_t* out, __m256i v, int mask) {
    // A register compress and a plain store: storing compressed is microcoded
    // on some processors.
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out),
                        _mm256_maskz_compress_epi32(static_cast<__mmask8>(mask), v));
    return out + __builtin_popcount(static_cast<unsigned>(mask));
}

SUPERRAY_TARGET inline __m256i gatherBytes(const std::uint8_t* base, __m256i offsets) {
    const __m256i words = _mm512_i64gather_epi32(_mm512_cvtepu32_epi64(offsets), base, 1);
    return _mm256_and_si256(words, _mm256_set1_epi32(255));
}

SUPERRAY_TARGET inline Doubles gatherDoubles(const double* base, const std::uint32_t* indices) {
    return (Doubles)_mm512_i64gather_pd(
        _mm512_cvtepu32_epi64(_mm256_load_si256(reinterpret_cast<const __m256i*>(indices))),
        base, 8);
}
SUPERRAY_TARGET inline Long8 of(Longs v) {
    return {(__m512i)v};
}

}  // namespace simd
}  // namespace
}  // namespace superray

// In this order: the later ones use the earlier.
#include "walk_vector.inc"
//
#include "saturation_vector.inc"
//
#include "lane_walk.inc"
//
#include "find_directions.inc"

namespace superray {

template <int Dim>
WalkKernels<Dim> avx512Kernels() {
    return {walkGroups<Dim>, walkLanes<Dim>, findDirections<Dim>, firstUnsaturated<Dim>};
}

template WalkKernels<2> avx512Kernels();
template WalkKernels<3> avx512Kernels();

}  // namespace superray
#endif
