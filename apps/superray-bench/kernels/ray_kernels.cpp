// SPDX-License-Identifier: BSD-3-Clause
// From points to the update batch.

#include <superray/core/culling_region.h>
#include <superray/core/super_rays.h>
#include <superray/core/traversal.h>

#include "kernel_data.h"

namespace superray {
namespace {

void pointsToRays(benchmark::State& state) {
    const KernelData& data = KernelData::of(state);
    for (auto _ : state) {
        RayBundle<3> rays(data.geometry, data.scan.origin.cast<double>());
        rays.reserve(data.scan.points.size());
        for (const Eigen::Vector3f& p : data.scan.points) rays.add(p.cast<double>());
        benchmark::DoNotOptimize(rays.size());
    }
    countPerIteration(state, "rays", data.rays.size());
}
BENCHMARK(pointsToRays)->Apply(onAllData);

void setUpLines(benchmark::State& state) {
    const KernelData& data = KernelData::of(state);
    for (auto _ : state) {
        std::int64_t slices = 0;
        for (std::size_t i = 0; i < data.rays.size(); ++i)
            slices += RayLine<3>(data.geometry, data.rays.origin(i), data.rays.end(i)).slices();
        benchmark::DoNotOptimize(slices);
    }
    countPerIteration(state, "rays", data.rays.size());
}
BENCHMARK(setUpLines)->Apply(onAllData);

/// The plain walk, cell by cell, which the engine's must equal.
void plainWalk(benchmark::State& state) {
    const KernelData& data = KernelData::of(state);
    for (auto _ : state) {
        std::uint64_t cells = 0;
        for (std::size_t i = 0; i < data.rays.size(); ++i)
            forEachFreeCell(RayLine<3>(data.geometry, data.rays.origin(i), data.rays.end(i)),
                            [&](Cell<3> cell) {
                                benchmark::DoNotOptimize(cell);
                                ++cells;
                            });
        benchmark::DoNotOptimize(cells);
    }
    countPerIteration(state, "cells", data.rayCells);
}
BENCHMARK(plainWalk)->Apply(onAllData);

void integrate(benchmark::State& state, Method method) {
    const KernelData& data = KernelData::of(state);
    ScanIntegrator<3> integrator;
    IntegratorOptions options;
    options.method = method;
    for (auto _ : state)
        benchmark::DoNotOptimize(
            &integrator.integrate(data.rays, data.model, options, data.grid.get()));
    countPerIteration(state, "cells", integrator.statistics().traversedCells);
}
BENCHMARK_CAPTURE(integrate, perRay, Method::perRay)->Apply(onAllData);
BENCHMARK_CAPTURE(integrate, superRays, Method::superRays)->Apply(onAllData);
BENCHMARK_CAPTURE(integrate, culling, Method::culling)->Apply(onAllData);
BENCHMARK_CAPTURE(integrate, full, Method::full)->Apply(onAllData);
BENCHMARK_CAPTURE(integrate, automatic, Method::automatic)->Apply(onAllData);

void groupSuperRays(benchmark::State& state) {
    const KernelData& data = KernelData::of(state);
    SuperRayGrouper<3> grouper;
    for (auto _ : state) benchmark::DoNotOptimize(grouper.group(data.rays, 20).size());
    countPerIteration(state, "rays", data.rays.size());
}
BENCHMARK(groupSuperRays)->Apply(onAllData);

void buildCullingRegion(benchmark::State& state) {
    const KernelData& data = KernelData::of(state);
    CullingRegion<3> region;
    BlockMask<3> mask;
    for (auto _ : state) {
        region.build(data.geometry.cellOf(data.rays.commonOrigin()), data.lowest, data.highest,
                     [&](const BlockKey<3>& key) {
                         mask = data.grid->saturation(key, data.model.min()).saturatedFree;
                         return mask.any() ? &mask : nullptr;
                     });
        benchmark::DoNotOptimize(region.cellCount());
    }
    countPerIteration(state, "cells", region.cellCount());
}
BENCHMARK(buildCullingRegion)->Apply(onAllData);

}  // namespace
}  // namespace superray

BENCHMARK_MAIN();
