// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The loop of fold_layers.h, for the vectors of any instruction set. A type
// `Lanes` is one:
//   F                          kCount floats
//   load, store, broadcast     of F
//   count(bytes)               kCount counts as floats
//   add, mul                   one rounding each: exactly
//   SensorModel::updated() max(a, b), min(a, b)       a > b ? a : b and a < b ?
//   a : b where0(c, a, b)            c == 0 ? a : b, per lane equalBits(a, b)
//   bit i: lane i is equal nonZero64(bytes)           bit i: byte i of 64 is
//   not 0
// fold_portable.cpp has them as scalars.
//
// Example of a cell: value -1.5, 2 misses of -0.4, lower clamp -2, then 1 hit
// of +0.8: max(-1.5 + 2 * -0.4, -2) = -2, and min(-2 + 1 * 0.8, highest) =
// -1.2.

#include "values/fold_layers.h"

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

template <typename Lanes>
void touchedCells(int layers, const std::uint8_t* misses, const std::uint8_t* hits,
                  std::uint64_t* touched) {
    for (int layer = 0; layer < layers; ++layer) {
        touched[layer] = Lanes::nonZero64(misses + 64 * layer);
        if (hits) touched[layer] |= Lanes::nonZero64(hits + 64 * layer);
    }
}

template <typename Lanes, UpdatePolicy policy, bool anyHits>
inline __attribute__((always_inline)) void foldAll(const FoldModel& model, const FoldTarget& t,
                                                   const std::uint8_t* misses,
                                                   const std::uint8_t* hits) {
    using F = typename Lanes::F;
    const F missStep = Lanes::broadcast(model.miss), lowest = Lanes::broadcast(model.min);
    const F hitStep = Lanes::broadcast(model.hit), highest = Lanes::broadcast(model.max);
    const F one = Lanes::broadcast(1.0f), zero = Lanes::broadcast(0.0f);
    constexpr std::uint64_t kLanes = ~std::uint64_t{0} >> (64 - Lanes::kCount);
    for (int layer = 0; layer < t.layers; ++layer) {
        const std::uint64_t touched = t.touched[layer];
        if (touched == 0) continue;
        const std::uint8_t* layerMisses = misses + 64 * layer;
        const std::uint8_t* layerHits = anyHits ? hits + 64 * layer : nullptr;
        float* values = t.values[layer];
        const std::uint64_t known = t.known[layer] | touched;
        std::uint64_t saturated = t.saturated[layer];
        for (int i = 0; i < 64; i += Lanes::kCount) {
            if ((touched >> i & kLanes) == 0) continue;
            F m = Lanes::count(layerMisses + i);
            F h = zero;
            if constexpr (anyHits) h = Lanes::count(layerHits + i);
            if constexpr (policy == UpdatePolicy::oncePerScan) {
                // hits = min(hits, 1); misses = hits == 0 ? min(misses, 1) : 0
                h = Lanes::min(h, one);
                m = Lanes::where0(h, Lanes::min(m, one), zero);
            }
            F value = Lanes::load(values + i);
            // if (misses > 0) value = max(value + misses * miss, lowest)
            const F missed = Lanes::add(value, Lanes::mul(m, missStep));
            value = Lanes::where0(m, value, Lanes::max(missed, lowest));
            if constexpr (anyHits) {
                // if (hits > 0) value = min(value + hits * hit, highest)
                const F hit = Lanes::add(value, Lanes::mul(h, hitStep));
                value = Lanes::where0(h, value, Lanes::min(hit, highest));
            }
            Lanes::store(values + i, value);
            // saturated[cell] = value == lowest
            const std::uint64_t atLowest = Lanes::equalBits(value, lowest);
            saturated = (saturated & ~(kLanes << i)) | atLowest << i;
        }
        t.known[layer] = known;
        t.saturated[layer] = saturated & known;
    }
}

template <typename Lanes>
void foldCounts(const FoldModel& model, const FoldTarget& t, const std::uint8_t* misses,
                const std::uint8_t* hits) {
    constexpr auto every = UpdatePolicy::everyRay, once = UpdatePolicy::oncePerScan;
    if (model.policy == every)
        hits ? foldAll<Lanes, every, true>(model, t, misses, hits)
             : foldAll<Lanes, every, false>(model, t, misses, hits);
    else
        hits ? foldAll<Lanes, once, true>(model, t, misses, hits)
             : foldAll<Lanes, once, false>(model, t, misses, hits);
}

template <typename Lanes>
FoldVersion foldVersion(const char* name) {
    return {name, touchedCells<Lanes>, foldCounts<Lanes>};
}

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
