// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file bench_engines.h
/// The built-in engines, one file each. (A list, because a linker leaves out
/// of a static library what only registers itself.)

#include <superray/eval/bench_engine.h>

namespace superray {

using BenchEngineList = std::vector<BenchEngineInfo>;

void listOctomapEngine(BenchEngineList& list);
void listOctomapRaysEngine(BenchEngineList& list);
void listMrptOctomapEngine(BenchEngineList& list);
void listMrptGrid3dEngine(BenchEngineList& list);
/// Lists nothing before MRPT 2.11, which has no such map.
void listMrptVoxelMapEngine(BenchEngineList& list);
void listSuperrayEngines(BenchEngineList& list);
void listCopiesEngines(BenchEngineList& list);

/// The parameters of peers that take OctoMap's.
template <class Map>
void setSensorModel(Map& map, PeerModel model) {
    if (model == PeerModel::own) return;
    const SensorProbabilities p;
    map.setProbHit(p.probHit);
    map.setProbMiss(p.probMiss);
    map.setClampingThresMin(p.clampMin);
    map.setClampingThresMax(p.clampMax);
}

}  // namespace superray
