// SPDX-License-Identifier: BSD-3-Clause
// OctoMap's scan graphs.

#include <octomap/ScanGraph.h>
#include <superray/eval/input_error.h>
#include <superray/eval/scan_source.h>

#include <sstream>

#include "fuzz/target.h"

namespace superray::fuzz {

std::vector<std::string> seeds() {
    octomap::ScanGraph graph;
    for (int node = 0; node < 2; ++node) {
        auto* const cloud = new octomap::Pointcloud;  // the graph's from addNode() on
        for (int i = 0; i < 5; ++i) cloud->push_back(static_cast<float>(i), 1, 2);
        graph.addNode(cloud, octomap::pose6d(0, 0, 1, 0, 0, 0.1));
    }
    std::ostringstream out;
    graph.writeBinary(out);
    return {out.str()};
}

void run(const std::string& input) {
    try {
        const auto source = openScanSource(asFile(input, "input.graph"), {});
        while (source->next()) continue;
    } catch (const InputError&) {
    }
}

}  // namespace superray::fuzz
