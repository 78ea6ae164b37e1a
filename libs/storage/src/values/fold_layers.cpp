// SPDX-License-Identifier: BSD-3-Clause
#include "values/fold_layers.h"

#if defined(__x86_64__) && defined(__GNUC__)
#define SUPERRAY_X86_VERSIONS 1
#include <immintrin.h>
#endif

namespace superray {
namespace {

/// One float at a time: every machine.
namespace portable {
struct Lanes {
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
#include "values/fold_kernel.inc"
}  // namespace portable

#ifdef SUPERRAY_X86_VERSIONS

/// Part of x86-64.
namespace sse2 {
struct Lanes {
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
#include "values/fold_kernel.inc"
}  // namespace sse2

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif
namespace avx2 {
struct Lanes {
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
#include "values/fold_kernel.inc"
}  // namespace avx2
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx512f,avx512bw"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw")
#endif
namespace avx512 {
struct Lanes {
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
#include "values/fold_kernel.inc"
}  // namespace avx512
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

#endif  // SUPERRAY_X86_VERSIONS

}  // namespace

int foldVersions(FoldVersion (&versions)[kMaxFoldVersions]) {
    int n = 0;
    versions[n++] = {"portable", portable::touchedCells, portable::foldCounts};
#ifdef SUPERRAY_X86_VERSIONS
    versions[n++] = {"sse2", sse2::touchedCells, sse2::foldCounts};
    if (__builtin_cpu_supports("avx2"))
        versions[n++] = {"avx2", avx2::touchedCells, avx2::foldCounts};
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw"))
        versions[n++] = {"avx512", avx512::touchedCells, avx512::foldCounts};
#endif
    return n;
}

const FoldVersion& foldForThisCpu() {
    static const FoldVersion fastest = [] {
        FoldVersion versions[kMaxFoldVersions];
        return versions[foldVersions(versions) - 1];
    }();
    return fastest;
}

}  // namespace superray
