// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What tests of equivalence share: a simple map, and how scans get into it.

#include <superray/core/reference_mapper.h>
#include <superray/core/scan_integrator.h>

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <unordered_map>

namespace superray::test {

/// The smallest map that can feed the culling region.
template <int Dim>
class TestMap : public SaturationSource<Dim> {
 public:
    void apply(const UpdateBatch<Dim>& batch, const SensorModel& model, UpdatePolicy policy) {
        for (std::size_t b = 0; b < batch.blockCount(); ++b) {
            const BlockMask<Dim> touched = batch.touched(b);
            for (int i = 0; i < kBlockCells<Dim>; ++i) {
                if (!touched.test(i)) continue;
                const unsigned hits = batch.hits(b) != nullptr ? batch.hits(b)[i] : 0;
                const Cell<Dim> cell = cellInBlock<Dim>(batch.key(b), i);
                set(cell, model.updated(value(cell), batch.misses(b)[i], hits, policy), model);
            }
        }
    }
    void apply(const CellCountMap<Dim>& counts, const SensorModel& model, UpdatePolicy policy) {
        for (const auto& [cell, n] : counts)
            set(cell, model.updated(value(cell), n.misses, n.hits, policy), model);
    }
    float value(const Cell<Dim>& cell) const {
        const auto it = cells.find(cell);
        return it == cells.end() ? 0 : it->second;
    }
    void set(const Cell<Dim>& cell, float v, const SensorModel& model) {
        cells[cell] = v;
        range_.include({v, v});
        BlockSaturation<Dim>& block = saturated_[blockOf<Dim>(cell)];
        const int i = indexInBlock<Dim>(cell);
        v == model.min() ? block.saturatedFree.set(i) : block.saturatedFree.reset(i);
        block.mayExceedUnknown |= v > 0;
    }
    BlockSaturation<Dim> saturation(const BlockKey<Dim>& key, float) const override {
        const auto it = saturated_.find(key);
        return it == saturated_.end() ? BlockSaturation<Dim>{} : it->second;
    }
    LogOddsRange valueRange() const override { return range_; }
    std::map<Cell<Dim>, float> cells;

 private:
    std::unordered_map<BlockKey<Dim>, BlockSaturation<Dim>, IndexHash> saturated_;
    LogOddsRange range_;
};

/// A scan into a map, by integrate() or from exact counts, as needsExactCounts() says.
/// \return whether from exact counts
template <int Dim>
bool insert(const RayBundle<Dim>& scan, const SensorModel& model,
            const IntegratorOptions& options, ScanIntegrator<Dim>& integrator,
            TestMap<Dim>& map) {
    if (ScanIntegrator<Dim>::needsExactCounts(options, model, &map)) {
        map.apply(countCells(scan), model, options.policy);
        return true;
    }
    map.apply(integrator.integrate(scan, model, options, &map), model, options.policy);
    return false;
}

inline SensorModel defaultModel(UpdatePolicy policy) {
    return SensorModel(SensorProbabilities::defaultsOf(policy));
}

template <int Dim>
void expectSameBits(const std::map<Cell<Dim>, float>& got,
                    const std::map<Cell<Dim>, float>& reference) {
    ASSERT_EQ(got.size(), reference.size());
    for (auto a = got.begin(), b = reference.begin(); a != got.end(); ++a, ++b) {
        ASSERT_EQ(a->first, b->first);
        ASSERT_EQ(std::memcmp(&a->second, &b->second, sizeof(float)), 0)
            << a->second << " " << b->second;
    }
}

inline constexpr Method kFastMethods[] = {Method::perRay, Method::superRays, Method::culling,
                                          Method::full, Method::automatic};

}  // namespace superray::test
