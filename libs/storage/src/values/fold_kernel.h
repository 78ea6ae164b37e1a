// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The loop of fold_layers.h, for the vectors of any instruction set. A type `Lanes` is one:
//
//   F                          kCount floats
//   load, store, broadcast     of F
//   count(bytes)               kCount counts as floats
//   add, mul                   one rounding each, as in SensorModel::updated()
//   max(a, b), min(a, b)       a > b ? a : b and a < b ? a : b
//   where0(c, a, b)            c == 0 ? a : b, per lane
//   equalBits(a, b)            bit i: lane i is equal
//   nonZero64(bytes)           bit i: byte i of 64 is not 0
//
// fold_portable.cpp has them as scalars.
//
// Example of a cell: value -1.5, 2 misses of -0.4, lower clamp -2, then 1 hit of +0.8:
// max(-1.5 + 2 * -0.4, -2) = -2, and min(-2 + 1 * 0.8, highest) = -1.2.

#include "values/fold_layers.h"

#include <superray/core/detail/always_inline.h>

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

/// SensorModel::updated() for some cells, under one policy.
template <typename Lanes, UpdatePolicy policy>
class CellUpdate {
    using F = typename Lanes::F;

 public:
    SUPERRAY_INLINE explicit CellUpdate(const FoldModel& model)
        : missStep_(Lanes::broadcast(model.miss)),
          hitStep_(Lanes::broadcast(model.hit)),
          lowest_(Lanes::broadcast(model.min)),
          highest_(Lanes::broadcast(model.max)),
          scanMiss_(Lanes::broadcast(model.scanMiss)),
          scanHit_(Lanes::broadcast(model.scanHit)),
          zero_(Lanes::broadcast(0.0f)),
          one_(Lanes::broadcast(1.0f)) {}

    F lowest() const { return lowest_; }

    /// \param m,h misses and hits
    template <bool anyHits>
    SUPERRAY_INLINE F updated(F value, F m, F h) const {
        if constexpr (policy == UpdatePolicy::netEvidence) {
            // evidence = max(scanMiss, min(scanHit, h * hit + m * miss))
            F sum = Lanes::mul(m, missStep_);
            if constexpr (anyHits) sum = Lanes::add(Lanes::mul(h, hitStep_), sum);
            const F evidence = Lanes::max(Lanes::min(sum, scanHit_), scanMiss_);
            // if (misses > 0 || hits > 0) value = max(min(value + evidence, highest), lowest)
            const F moved = Lanes::min(Lanes::add(value, evidence), highest_);
            return Lanes::where0(anyHits ? Lanes::max(m, h) : m, value,
                                 Lanes::max(moved, lowest_));
        }
        if constexpr (policy == UpdatePolicy::oncePerScan) {
            // hits = min(hits, 1); misses = hits == 0 ? min(misses, 1) : 0
            h = Lanes::min(h, one_);
            m = Lanes::where0(h, Lanes::min(m, one_), zero_);
        }
        // if (misses > 0) value = max(value + misses * miss, lowest)
        const F missed = Lanes::add(value, Lanes::mul(m, missStep_));
        value = Lanes::where0(m, value, Lanes::max(missed, lowest_));
        if constexpr (anyHits) {
            // if (hits > 0) value = min(value + hits * hit, highest)
            const F hit = Lanes::add(value, Lanes::mul(h, hitStep_));
            value = Lanes::where0(h, value, Lanes::min(hit, highest_));
        }
        return value;
    }

 private:
    F missStep_, hitStep_, lowest_, highest_, scanMiss_, scanHit_, zero_, one_;
};

template <typename Lanes, UpdatePolicy policy, bool anyHits>
SUPERRAY_INLINE void foldAll(const FoldModel& model, const FoldTarget& t,
                             const std::uint8_t* misses, const std::uint8_t* hits) {
    using F = typename Lanes::F;
    const CellUpdate<Lanes, policy> update(model);
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
            const F m = Lanes::count(layerMisses + i);
            F h = Lanes::broadcast(0.0f);
            if constexpr (anyHits) h = Lanes::count(layerHits + i);
            const F value = update.template updated<anyHits>(Lanes::load(values + i), m, h);
            Lanes::store(values + i, value);
            // saturated[cell] = value == lowest
            const std::uint64_t atLowest = Lanes::equalBits(value, update.lowest());
            saturated = (saturated & ~(kLanes << i)) | atLowest << i;
        }
        t.known[layer] = known;
        t.saturated[layer] = saturated & known;
    }
}

template <typename Lanes, UpdatePolicy policy>
void foldUnder(const FoldModel& model, const FoldTarget& t, const std::uint8_t* misses,
               const std::uint8_t* hits) {
    hits ? foldAll<Lanes, policy, true>(model, t, misses, hits)
         : foldAll<Lanes, policy, false>(model, t, misses, hits);
}

template <typename Lanes>
void foldCounts(const FoldModel& model, const FoldTarget& t, const std::uint8_t* misses,
                const std::uint8_t* hits) {
    switch (model.policy) {
        case UpdatePolicy::everyRay:
            return foldUnder<Lanes, UpdatePolicy::everyRay>(model, t, misses, hits);
        case UpdatePolicy::oncePerScan:
            return foldUnder<Lanes, UpdatePolicy::oncePerScan>(model, t, misses, hits);
        case UpdatePolicy::netEvidence:
            return foldUnder<Lanes, UpdatePolicy::netEvidence>(model, t, misses, hits);
    }
}

template <typename Lanes>
FoldVersion foldVersion(const char* name) {
    return {name, touchedCells<Lanes>, foldCounts<Lanes>};
}

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
