// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file kernel_data.h
/// Scans and maps that the kernels work on, made once.

#include <benchmark/benchmark.h>
#include <superray/core/ray_line.h>
#include <superray/core/scan_integrator.h>
#include <superray/eval/point_scan.h>
#include <superray/storage/map_file.h>

#include <memory>
#include <string>

namespace superray {

/// A scan of a simulated world, and maps of the scans before it.
class KernelData {
 public:
    /// That of a benchmark with the arguments `world` (0: indoor, 1: outdoor)
    /// and `resolution` [cm].
    static const KernelData& of(const benchmark::State& state);

    CellGeometry<3> geometry;
    SensorModel model;
    PointScan scan;
    RayBundle<3> rays;                              ///< of the scan
    std::unique_ptr<OccupancyMap<3>> grid, octree;  ///< before the scan
    Cell<3> lowest{}, highest{};                    ///< extent of the scan
    std::uint64_t rayCells = 0;                     ///< cells before the end cells, of all rays

    KernelData(const std::string& world, double resolution);
};

/// Runs a kernel on both worlds, at 0.1, 0.2 and 0.4 m.
void onAllData(benchmark::internal::Benchmark* kernel);

/// Rates next to the time: `count` things per iteration.
void countPerIteration(benchmark::State& state, const char* name, std::uint64_t count);

}  // namespace superray
