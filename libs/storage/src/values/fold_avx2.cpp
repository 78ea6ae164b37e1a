// SPDX-License-Identifier: BSD-3-Clause
// The fold loop for AVX2: 8 cells at a time.
#define SUPERRAY_TARGET_AVX2

#if defined(__x86_64__)
#include <immintrin.h>

#include "values/fold_kernel.h"
#include "values/fold_versions.h"

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

struct Avx2Lanes {
    using F = __m256;
    static constexpr int kCount = 8;
    static F load(const float* p) { return _mm256_loadu_ps(p); }
    static void store(float* p, F v) { _mm256_storeu_ps(p, v); }
    static F broadcast(float v) { return _mm256_set1_ps(v); }
    static F count(const std::uint8_t* p) {
        return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadu_si64(p)));
    }
    static F add(F a, F b) { return _mm256_add_ps(a, b); }
    static F mul(F a, F b) { return _mm256_mul_ps(a, b); }
    static F max(F a, F b) { return _mm256_max_ps(a, b); }
    static F min(F a, F b) { return _mm256_min_ps(a, b); }
    static F where0(F c, F a, F b) {
        return _mm256_blendv_ps(b, a, _mm256_cmp_ps(c, _mm256_setzero_ps(), _CMP_EQ_OQ));
    }
    static std::uint64_t equalBits(F a, F b) {
        return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_EQ_OQ)));
    }
    static std::uint64_t nonZero64(const std::uint8_t* p) {
        std::uint64_t zeros = 0;
        for (int i = 0; i < 64; i += 32) {
            const __m256i bytes = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p + i));
            const int bits =
                _mm256_movemask_epi8(_mm256_cmpeq_epi8(bytes, _mm256_setzero_si256()));
            zeros |= std::uint64_t{static_cast<unsigned>(bits)} << i;
        }
        return ~zeros;
    }
};

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>

namespace superray {

FoldVersion avx2Fold() {
    return foldVersion<Avx2Lanes>("avx2");
}

}  // namespace superray
#endif
