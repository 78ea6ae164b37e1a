// SPDX-License-Identifier: BSD-3-Clause
#include "engines/octomap_tree_engine.h"

namespace superray {
namespace {

class OctomapRaysEngine final : public OctomapTreeEngine {
 public:
    using OctomapTreeEngine::OctomapTreeEngine;
    void insert() override { tree_.insertPointCloudRays(cloud_, origin_); }
};

}  // namespace

void listOctomapRaysEngine(BenchEngineList& list) {
    list.push_back({"octomap-rays", "liboctomap, OcTree::insertPointCloudRays()", false,
                    "rayByRay", false, [](const BenchEngineOptions& options) {
                        return std::make_unique<OctomapRaysEngine>(options);
                    }});
}

}  // namespace superray
