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

/// A scan into the map of the scans before it.
void applyToKnown(benchmark::State& state, MapMember member) {
    const KernelData& data = KernelData::of(state);
    const OccupancyMap<3>& before = *(data.*member);
    ScanIntegrator<3> integrator;
    const IntegratorOptions options;
    const auto& batch = integrator.integrate(data.rays, data.model, options, &before);
    for (auto _ : state) {
        state.PauseTiming();
        auto map = before.clone();
        state.ResumeTiming();
        map->apply(batch, data.model, options.policy);
        state.PauseTiming();
        map.reset();
        state.ResumeTiming();
    }
    countPerIteration(state, "cells", touchedCells(batch));
}
BENCHMARK_CAPTURE(applyToKnown, grid, &KernelData::grid)->Apply(onAllData);
BENCHMARK_CAPTURE(applyToKnown, octree, &KernelData::octree)->Apply(onAllData);

/// A scan into an empty map: every block is new.
void applyToEmpty(benchmark::State& state, MapMember member) {
    const KernelData& data = KernelData::of(state);
    ScanIntegrator<3> integrator;
    const IntegratorOptions options;
    const auto& batch = integrator.integrate(data.rays, data.model, options, nullptr);
    for (auto _ : state) {
        state.PauseTiming();
        auto map = (data.*member)->emptyLike(data.geometry);
        state.ResumeTiming();
        map->apply(batch, data.model, options.policy);
        state.PauseTiming();
        map.reset();
        state.ResumeTiming();
    }
    countPerIteration(state, "cells", touchedCells(batch));
}
BENCHMARK_CAPTURE(applyToEmpty, grid, &KernelData::grid)->Apply(onAllData);
BENCHMARK_CAPTURE(applyToEmpty, octree, &KernelData::octree)->Apply(onAllData);

}  // namespace
}  // namespace superray
