// SPDX-License-Identifier: BSD-3-Clause
// The fold loop for AVX-512: 16 cells at a time.
#define SUPERRAY_TARGET_AVX512

#if defined(__x86_64__)
#include <immintrin.h>

#include "values/fold_kernel.h"
#include "values/fold_versions.h"

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

struct Avx512Lanes {
    using F = __m512;
    static constexpr int kCount = 16;
    static F load(const float* p) { return _mm512_loadu_ps(p); }
    static void store(float* p, F v) { _mm512_storeu_ps(p, v); }
    static F broadcast(float v) { return _mm512_set1_ps(v); }
    static F count(const std::uint8_t* p) {
        const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));
        return _mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(bytes));
    }
    static F add(F a, F b) { return _mm512_add_ps(a, b); }
    static F mul(F a, F b) { return _mm512_mul_ps(a, b); }
    static F max(F a, F b) { return _mm512_max_ps(a, b); }
    static F min(F a, F b) { return _mm512_min_ps(a, b); }
    static F where0(F c, F a, F b) {
        return _mm512_mask_blend_ps(_mm512_cmp_ps_mask(c, _mm512_setzero_ps(), _CMP_EQ_OQ), b,
                                    a);
    }
    static std::uint64_t equalBits(F a, F b) { return _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ); }
    static std::uint64_t nonZero64(const std::uint8_t* p) {
        const __m512i bytes = _mm512_loadu_si512(p);
        return _mm512_test_epi8_mask(bytes, bytes);
    }
};

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>

namespace superray {

FoldVersion avx512Fold() {
    return foldVersion<Avx512Lanes>("avx512");
}

}  // namespace superray
#endif
