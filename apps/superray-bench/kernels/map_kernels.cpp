// SPDX-License-Identifier: BSD-3-Clause
// From the update batch to the map.

#include "kernel_data.h"

namespace superray {
namespace {

using MapMember = std::unique_ptr<OccupancyMap<3>> KernelData::*;

std::uint64_t touchedCells(const UpdateBatch<3>& batch) {
    std::uint64_t cells = 0;
    for (std::size_t i = 0; i < batch.blockCount(); ++i)
        cells += static_cast<std::uint64_t>(batch.touched(i).count());
    return cells;
}

/// Applies the scan to a map that `makeMap` makes, which is not timed.
template <class MakeMap>
void applyScan(benchmark::State& state, const OccupancyMap<3>* saturated,
               const MakeMap& makeMap) {
    const KernelData& data = KernelData::of(state);
    ScanIntegrator<3> integrator;
    const IntegratorOptions options;
    const auto& batch = integrator.integrate(data.rays, data.model, options, saturated);
    for (auto _ : state) {
        state.PauseTiming();
        auto map = makeMap();
        state.ResumeTiming();
        map->apply(batch, data.model, options.policy);
        state.PauseTiming();
        map.reset();
        state.ResumeTiming();
    }
    countPerIteration(state, "cells", touchedCells(batch));
}

/// A scan into the map of the scans before it.
void applyToKnown(benchmark::State& state, MapMember member) {
    const OccupancyMap<3>& before = *(KernelData::of(state).*member);
    applyScan(state, &before, [&] { return before.clone(); });
}
BENCHMARK_CAPTURE(applyToKnown, grid, &KernelData::grid)->Apply(onAllData);
BENCHMARK_CAPTURE(applyToKnown, octree, &KernelData::octree)->Apply(onAllData);

/// A scan into an empty map: every block is new.
void applyToEmpty(benchmark::State& state, MapMember member) {
    const OccupancyMap<3>& before = *(KernelData::of(state).*member);
    applyScan(state, nullptr, [&] { return before.emptyLike(before.geometry()); });
}
BENCHMARK_CAPTURE(applyToEmpty, grid, &KernelData::grid)->Apply(onAllData);
BENCHMARK_CAPTURE(applyToEmpty, octree, &KernelData::octree)->Apply(onAllData);

}  // namespace
}  // namespace superray
