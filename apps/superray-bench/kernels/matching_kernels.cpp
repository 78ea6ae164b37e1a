// SPDX-License-Identifier: BSD-3-Clause
// A scan against a map of it: likelihood, and the pairs of one ICP iteration. MRPT's
// own maps beside ours (COctoMap has no matching).

#include <mrpt/maps/COctoMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/tfest/TMatchingPair.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>

#include <map>

#include "kernel_data.h"

namespace superray {
namespace {

constexpr std::size_t kPoints = 10000;

/// A scan in the frame of its sensor, and at most kPoints of it to ask with.
struct ScanData {
    mrpt::obs::CObservationPointCloud whole, part;
    mrpt::poses::CPose3D pose, nearby;

    explicit ScanData(const PointScan& scan)
        : pose(scan.origin.x(), scan.origin.y(), scan.origin.z(), 0, 0, 0),
          nearby(pose + mrpt::poses::CPose3D(0.05, -0.03, 0.02, 0.01, 0, 0)) {
        whole.pointcloud = mrpt::maps::CSimplePointsMap::Create();
        part.pointcloud = mrpt::maps::CSimplePointsMap::Create();
        const std::size_t step = (scan.points.size() + kPoints - 1) / kPoints;
        for (std::size_t i = 0; i < scan.points.size(); ++i) {
            const Eigen::Vector3f p = scan.points[i] - scan.origin;
            whole.pointcloud->insertPoint(p.x(), p.y(), p.z());
            if (i % step == 0) part.pointcloud->insertPoint(p.x(), p.y(), p.z());
        }
    }

    static const ScanData& of(const benchmark::State& state) {
        static std::map<const KernelData*, std::unique_ptr<ScanData>> all;
        const KernelData& data = KernelData::of(state);
        auto& scan = all[&data];
        if (!scan) scan = std::make_unique<ScanData>(data.scan);
        return *scan;
    }
};

/// The map of the whole scan, in cells of the benchmark's size where it has cells.
template <class Map>
std::unique_ptr<Map> mapOf(const benchmark::State& state) {
    const ScanData& scan = ScanData::of(state);
    std::unique_ptr<Map> map;
    if constexpr (std::is_base_of_v<mrpt::maps::CPointsMap, Map>) {
        map = std::make_unique<Map>();
        map->insertAnotherMap(scan.whole.pointcloud.get(), scan.pose);
    } else {
        map = std::make_unique<Map>(0.01 * static_cast<double>(state.range(1)));
        map->insertObservation(scan.whole, scan.pose);
    }
    map->likelihoodOptions.decimation = 1;
    return map;
}

template <class Map>
void insertion(benchmark::State& state) {
    const ScanData& scan = ScanData::of(state);
    for (auto _ : state) {
        state.PauseTiming();
        auto map = mapOf<Map>(state);
        state.ResumeTiming();
        map->insertObservation(scan.part, scan.nearby);
        state.PauseTiming();
        map.reset();
        state.ResumeTiming();
    }
    countPerIteration(state, "points", scan.part.pointcloud->size());
}

template <class Map>
void likelihood(benchmark::State& state) {
    const ScanData& scan = ScanData::of(state);
    const auto map = mapOf<Map>(state);
    for (auto _ : state)
        benchmark::DoNotOptimize(map->computeObservationLikelihood(scan.part, scan.nearby));
    countPerIteration(state, "points", scan.part.pointcloud->size());
}

template <class Map>
void icpPairs(benchmark::State& state) {
    const ScanData& scan = ScanData::of(state);
    const auto map = mapOf<Map>(state);
    mrpt::maps::TMatchingParams params;
    params.maxDistForCorrespondence = 0.3f;
    mrpt::tfest::TMatchingPairList pairs;
    mrpt::maps::TMatchingExtraResults extra;
    for (auto _ : state)
        map->determineMatching3D(scan.part.pointcloud.get(), scan.nearby, pairs, params, extra);
    countPerIteration(state, "points", scan.part.pointcloud->size());
    state.counters["paired"] = static_cast<double>(extra.correspondencesRatio);
}

using mrpt::maps::COctoMap;
using mrpt::maps::CSimplePointsMap;

BENCHMARK_TEMPLATE(insertion, CSuperRayGridMap3D)->Apply(onAllData);
BENCHMARK_TEMPLATE(insertion, CSuperRayOctoMap)->Apply(onAllData);
BENCHMARK_TEMPLATE(insertion, COctoMap)->Apply(onAllData);
BENCHMARK_TEMPLATE(likelihood, CSuperRayGridMap3D)->Apply(onAllData);
BENCHMARK_TEMPLATE(likelihood, CSuperRayOctoMap)->Apply(onAllData);
BENCHMARK_TEMPLATE(likelihood, COctoMap)->Apply(onAllData);
BENCHMARK_TEMPLATE(likelihood, CSimplePointsMap)->Apply(onAllData);
BENCHMARK_TEMPLATE(icpPairs, CSuperRayGridMap3D)->Apply(onAllData);
BENCHMARK_TEMPLATE(icpPairs, CSuperRayOctoMap)->Apply(onAllData);
BENCHMARK_TEMPLATE(icpPairs, CSimplePointsMap)->Apply(onAllData);

}  // namespace
}  // namespace superray
