// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/bench_engine.h>
#include <superray/eval/input_error.h>

#include <algorithm>
#include <stdexcept>

#include "engines/bench_engines.h"

namespace superray {
namespace {

BenchEngineList& registry() {
    static BenchEngineList list = [] {
        BenchEngineList all;
        for (const auto add : {listOctomapEngine, listOctomapRaysEngine, listMrptOctomapEngine,
                               listMrptGrid3dEngine, listMrptVoxelMapEngine,
                               listSuperrayEngines, listCopiesEngines})
            add(all);
        return all;
    }();
    return list;
}

BenchEngineList::const_iterator find(const std::string& name) {
    const auto& all = registry();
    return std::find_if(all.begin(), all.end(), [&](const auto& e) { return e.name == name; });
}

}  // namespace

BenchWork& BenchWork::operator+=(const BenchWork& o) {
    toRaysSeconds += o.toRaysSeconds;
    superRaySeconds += o.superRaySeconds;
    cullingSeconds += o.cullingSeconds;
    traversalSeconds += o.traversalSeconds;
    applySeconds += o.applySeconds;
    rays += o.rays;
    superRays += o.superRays;
    traversedCells += o.traversedCells;
    cullingCells += o.cullingCells;
    touchedBlocks += o.touchedBlocks;
    return *this;
}

const char* toString(PeerModel model) {
    return model == PeerModel::shared ? "shared" : "own";
}

PeerModel peerModelFromString(const std::string& name) {
    for (const PeerModel model : {PeerModel::shared, PeerModel::own})
        if (name == toString(model)) return model;
    throw std::invalid_argument("unknown model of peers '" + name + "': must be shared or own");
}

const std::vector<BenchEngineInfo>& benchEngines() {
    return registry();
}

const BenchEngineInfo& benchEngine(const std::string& name) {
    const auto found = find(name);
    if (found != registry().end()) return *found;
    if (name == "mrpt-voxelmap")
        throw InputError(
            "engine 'mrpt-voxelmap' needs MRPT >= 2.11; this program was built "
            "with an older one");
    std::string names;
    for (const auto& engine : registry()) names += (names.empty() ? "" : ", ") + engine.name;
    throw InputError("unknown engine '" + name + "'; known are " + names);
}

void addBenchEngine(BenchEngineInfo info) {
    if (find(info.name) != registry().end())
        throw std::invalid_argument("there is already an engine '" + info.name + "'");
    registry().push_back(std::move(info));
}

}  // namespace superray
