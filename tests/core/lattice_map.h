// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Rays on and beside borders of cells against the oracle: a map around them, and the
// comparison.

#include <superray/core/reference_mapper.h>
#include <superray/core/scan_integrator.h>

#include <optional>
#include <string>

#include "core/counts_of.h"
#include "core/test_map.h"

namespace superray::test {

/// A map in which all cells are free for certain, but for some that nothing is known of.
template <int Dim>
class HoledMap : public SaturationSource<Dim> {
 public:
    /// \param oneIn of so many cells, one is unknown; 1: all are
    HoledMap(std::uint64_t seed, std::uint64_t oneIn) : seed_(seed), oneIn_(oneIn) {}

    bool unknown(const Cell<Dim>& cell) const {
        std::uint64_t h = seed_;
        for (const std::int32_t c : cell)
            h = (h ^ static_cast<std::uint32_t>(c)) * 0x9E3779B97F4A7C15u, h ^= h >> 29;
        return h % oneIn_ == 0;
    }
    BlockSaturation<Dim> saturation(const BlockKey<Dim>& key, float) const override {
        BlockSaturation<Dim> block;
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (!unknown(cellInBlock<Dim>(key, i))) block.saturatedFree.set(i);
        return block;
    }
    LogOddsRange valueRange() const override { return {SensorModel().min(), 0}; }

 private:
    std::uint64_t seed_, oneIn_;
};

/// A cell that two counts leave different, where every cell is as `map` has it before.
/// Cells that nothing is known of must be touched by both or by none.
template <int Dim>
std::optional<Cell<Dim>> firstDifference(const CellCountMap<Dim>& got,
                                         const CellCountMap<Dim>& expected,
                                         const HoledMap<Dim>& map, const SensorModel& model,
                                         UpdatePolicy policy) {
    const auto after = [&](const Cell<Dim>& cell, const CellCountMap<Dim>& counts) {
        const auto it = counts.find(cell);
        const float before = map.unknown(cell) ? 0 : model.min();
        return it == counts.end()
                   ? before
                   : model.updated(before, it->second.misses, it->second.hits, policy);
    };
    for (const auto* counts : {&got, &expected})
        for (const auto& [cell, count] : *counts)
            if (after(cell, got) != after(cell, expected) ||
                (map.unknown(cell) && got.count(cell) != expected.count(cell)))
                return cell;
    return std::nullopt;
}

/// Updates of the map by every fast method and policy, against the counts of the oracle.
/// \param onRun (method, statistics) called after each
/// \return the first method and policy that differs, in words; empty: none
template <int Dim, class OnRun>
std::string firstDifferentRun(const RayBundle<Dim>& rays, const CellCountMap<Dim>& expected,
                              const HoledMap<Dim>& map, unsigned threads,
                              ScanIntegrator<Dim>& integrator, const OnRun& onRun) {
    for (const Method method : kFastMethods) {
        for (const UpdatePolicy policy : kUpdatePolicies) {
            const SensorModel model = defaultModel(policy);
            IntegratorOptions options;
            options.method = method;
            options.policy = policy;
            options.superRayThreshold = 1;
            options.threads = threads;
            const auto counts = countsOf(integrator.integrate(rays, model, options, &map));
            if (firstDifference(counts, expected, map, model, policy))
                return std::string(toString(method)) + ", " + toString(policy);
            onRun(method, integrator.statistics());
        }
    }
    return {};
}

}  // namespace superray::test
