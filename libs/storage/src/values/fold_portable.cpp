// SPDX-License-Identifier: BSD-3-Clause
// The fold loop for any processor, and for any x86-64.
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "values/fold_kernel.h"
#include "values/fold_versions.h"

namespace superray {
namespace {

/// One float at a time.
struct ScalarLanes {
    using F = float;
    static constexpr int kCount = 1;
    static F load(const float* p) { return *p; }
    static void store(float* p, F v) { *p = v; }
    static F broadcast(float v) { return v; }
    static F count(const std::uint8_t* p) { return static_cast<float>(*p); }
    static F add(F a, F b) { return a + b; }
    static F mul(F a, F b) { return a * b; }
    static F max(F a, F b) { return a > b ? a : b; }
    static F min(F a, F b) { return a < b ? a : b; }
    static F where0(F c, F a, F b) { return c == 0.0f ? a : b; }
    static std::uint64_t equalBits(F a, F b) { return a == b; }
    static std::uint64_t nonZero64(const std::uint8_t* p) {
        std::uint64_t bits = 0;
        for (int i = 0; i < 64; ++i) bits |= std::uint64_t{p[i] != 0} << i;
        return bits;
    }
};

#if defined(__x86_64__)
/// 4 floats at a time.
struct Sse2Lanes {
    using F = __m128;
    static constexpr int kCount = 4;
    static F load(const float* p) { return _mm_loadu_ps(p); }
    static void store(float* p, F v) { _mm_storeu_ps(p, v); }
    static F broadcast(float v) { return _mm_set1_ps(v); }
    static F count(const std::uint8_t* p) {
        const __m128i zero = _mm_setzero_si128();
        const __m128i bytes = _mm_loadu_si32(p);
        return _mm_cvtepi32_ps(_mm_unpacklo_epi16(_mm_unpacklo_epi8(bytes, zero), zero));
    }
    static F add(F a, F b) { return _mm_add_ps(a, b); }
    static F mul(F a, F b) { return _mm_mul_ps(a, b); }
    static F max(F a, F b) { return _mm_max_ps(a, b); }
    static F min(F a, F b) { return _mm_min_ps(a, b); }
    static F where0(F c, F a, F b) {
        const __m128 isZero = _mm_cmpeq_ps(c, _mm_setzero_ps());
        return _mm_or_ps(_mm_and_ps(isZero, a), _mm_andnot_ps(isZero, b));
    }
    static std::uint64_t equalBits(F a, F b) {
        return static_cast<unsigned>(_mm_movemask_ps(_mm_cmpeq_ps(a, b)));
    }
    static std::uint64_t nonZero64(const std::uint8_t* p) {
        std::uint64_t zeros = 0;
        for (int i = 0; i < 64; i += 16) {
            const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(p + i));
            const int bits = _mm_movemask_epi8(_mm_cmpeq_epi8(bytes, _mm_setzero_si128()));
            zeros |= std::uint64_t{static_cast<unsigned>(bits)} << i;
        }
        return ~zeros;
    }
};
#endif

}  // namespace

FoldVersion portableFold() {
    return foldVersion<ScalarLanes>("portable");
}

#if defined(__x86_64__)
FoldVersion sse2Fold() {
    return foldVersion<Sse2Lanes>("sse2");
}
#endif

}  // namespace superray
