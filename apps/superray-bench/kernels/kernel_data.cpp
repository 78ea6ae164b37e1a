// SPDX-License-Identifier: BSD-3-Clause
#include "kernel_data.h"

#include <algorithm>
#include <map>

namespace superray {
namespace {

constexpr std::size_t kScansBefore = 4;

RayBundle<3> toRays(const CellGeometry<3>& geometry, const PointScan& scan) {
    RayBundle<3> rays(geometry, scan.origin.cast<double>());
    rays.reserve(scan.points.size());
    for (const Eigen::Vector3f& p : scan.points) rays.add(p.cast<double>());
    return rays;
}

std::vector<PointScan> scansOf(const std::string& world) {
    PointScanRequest request;
    request.data = world;
    request.source.maxScans = kScansBefore + 1;
    return loadPointScans(request).scans;
}

}  // namespace

KernelData::KernelData(const std::string& world, double resolution)
    : geometry(resolution),
      rays(geometry, Point<3>::Zero()),
      grid(makeStorage<3>(StorageType::blockGrid, geometry)),
      octree(makeStorage<3>(StorageType::tree, geometry)) {
    const auto scans = scansOf(world);
    ScanIntegrator<3> integrator;
    const IntegratorOptions options;
    for (std::size_t i = 0; i < kScansBefore; ++i) {
        const auto& batch =
            integrator.integrate(toRays(geometry, scans[i]), model, options, grid.get());
        grid->apply(batch, model, options.policy);
        octree->apply(batch, model, options.policy);
    }
    scan = scans.back();
    rays = toRays(geometry, scan);
    lowest = highest = geometry.cellOf(rays.commonOrigin());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Cell<3> end = geometry.cellOf(rays.end(i));
        for (std::size_t a = 0; a < 3; ++a) {
            lowest[a] = std::min(lowest[a], end[a]);
            highest[a] = std::max(highest[a], end[a]);
        }
        rayCells += static_cast<std::uint64_t>(
            RayLine<3>(geometry, rays.origin(i), rays.end(i)).steps());
    }
}

const KernelData& KernelData::of(const benchmark::State& state) {
    using Key = std::pair<std::int64_t, std::int64_t>;
    static std::map<Key, std::unique_ptr<KernelData>> all;
    auto& data = all[{state.range(0), state.range(1)}];
    if (!data)
        data = std::make_unique<KernelData>(state.range(0) == 0 ? "indoor" : "outdoor",
                                            0.01 * static_cast<double>(state.range(1)));
    return *data;
}

void onAllData(benchmark::internal::Benchmark* kernel) {
    kernel->ArgNames({"outdoor", "cm"})->ArgsProduct({{0, 1}, {10, 20, 40}});
    kernel->Unit(benchmark::kMillisecond);
}

void countPerIteration(benchmark::State& state, const char* name, std::uint64_t count) {
    state.counters[name] = benchmark::Counter(static_cast<double>(count),
                                              benchmark::Counter::kIsIterationInvariantRate);
}

}  // namespace superray
