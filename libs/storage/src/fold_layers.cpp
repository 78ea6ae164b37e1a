#include "fold_layers.h"

#include <cstring>

#if defined(__x86_64__) && defined(__GNUC__)
#define SUPERRAY_X86_VERSIONS 1
#endif

namespace superray {
namespace {

/// Bit i of the result is set if byte i is not zero.
inline __attribute__((always_inline)) std::uint64_t nonZeroBytes(const std::uint8_t* bytes) {
    std::uint64_t bits = 0;
    for (int row = 0; row < 8; ++row) {
        std::uint64_t b = 0;
        for (int i = 0; i < 8; ++i) b |= std::uint64_t{bytes[8 * row + i]} << (8 * i);
        // Top bit of each byte: set if the byte is not zero.
        const std::uint64_t low = 0x7F7F7F7F7F7F7F7Full;
        const std::uint64_t top = (((b & low) + low) | b) & ~low;
        // Gathers the eight top bits into one byte.
        bits |= (((top >> 7) * 0x0102040810204080ull) >> 56) << (8 * row);
    }
    return bits;
}

/// Plain arrays, so that the compiler vectorises the loop for each target. The
/// order is miss, clamp, hit, clamp with separate multiplications and additions:
/// exactly SensorModel::updated().
template <UpdatePolicy policy>
inline __attribute__((always_inline)) void foldLayer(const FoldModel& model,
                                                     const std::uint8_t* __restrict misses,
                                                     const std::uint8_t* __restrict hits,
                                                     float* __restrict values,
                                                     std::uint8_t* __restrict atMin) {
    constexpr bool once = policy == UpdatePolicy::oncePerScan;
    for (int i = 0; i < 64; ++i) {
        const int h = once ? hits[i] != 0 : hits[i];
        const int m = once ? (misses[i] != 0) & (hits[i] == 0) : misses[i];
        const float value = values[i];
        const float missed = value + static_cast<float>(m) * model.miss;
        const float clampedMissed = missed > model.min ? missed : model.min;
        const float afterMisses = m != 0 ? clampedMissed : value;
        const float hit = afterMisses + static_cast<float>(h) * model.hit;
        const float clampedHit = hit < model.max ? hit : model.max;
        const float result = h != 0 ? clampedHit : afterMisses;
        values[i] = result;
        atMin[i] = result == model.min;
    }
}

template <UpdatePolicy policy>
inline __attribute__((always_inline)) void foldAll(const FoldModel& model, const FoldTarget& t,
                                                   const std::uint8_t* misses,
                                                   const std::uint8_t* hits) {
    alignas(64) static constexpr std::uint8_t kNoHits[64] = {};
    for (int layer = 0; layer < t.layers; ++layer) {
        const std::uint8_t* m = misses + 64 * layer;
        const std::uint8_t* h = hits ? hits + 64 * layer : kNoHits;
        const std::uint64_t touched = nonZeroBytes(m) | (hits ? nonZeroBytes(h) : 0);
        if (touched == 0) continue;
        alignas(64) std::uint8_t atMin[64];
        foldLayer<policy>(model, m, h, t.values + 64 * layer, atMin);
        t.known[layer] |= touched;
        t.saturated[layer] = nonZeroBytes(atMin) & t.known[layer];
    }
}

inline __attribute__((always_inline)) void foldEither(const FoldModel& model,
                                                      const FoldTarget& target,
                                                      const std::uint8_t* misses,
                                                      const std::uint8_t* hits) {
    if (model.policy == UpdatePolicy::everyRay)
        foldAll<UpdatePolicy::everyRay>(model, target, misses, hits);
    else
        foldAll<UpdatePolicy::oncePerScan>(model, target, misses, hits);
}

void foldPortable(const FoldModel& model, const FoldTarget& target, const std::uint8_t* misses,
                  const std::uint8_t* hits) {
    foldEither(model, target, misses, hits);
}

#ifdef SUPERRAY_X86_VERSIONS
__attribute__((target("avx2"))) void foldAvx2(const FoldModel& model, const FoldTarget& target,
                                              const std::uint8_t* misses,
                                              const std::uint8_t* hits) {
    foldEither(model, target, misses, hits);
}

__attribute__((target("avx512f,avx512bw,avx512vl,avx512dq,prefer-vector-width=512"))) void
foldAvx512(const FoldModel& model, const FoldTarget& target, const std::uint8_t* misses,
           const std::uint8_t* hits) {
    foldEither(model, target, misses, hits);
}
#endif

}  // namespace

int foldVersions(FoldVersion (&versions)[3]) {
    int n = 0;
    versions[n++] = {"portable", foldPortable};
#ifdef SUPERRAY_X86_VERSIONS
    if (__builtin_cpu_supports("avx2")) versions[n++] = {"avx2", foldAvx2};
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"))
        versions[n++] = {"avx512", foldAvx512};
#endif
    return n;
}

FoldLayers foldLayersForThisCpu() {
    static const FoldLayers fastest = [] {
        FoldVersion versions[3];
        return versions[foldVersions(versions) - 1].fold;
    }();
    return fastest;
}

}  // namespace superray
