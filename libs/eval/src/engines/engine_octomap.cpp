// SPDX-License-Identifier: BSD-3-Clause
#include "engines/octomap_tree_engine.h"

namespace superray {

BlockGrid<3> cellsOf(const octomap::OcTree& tree) {
    BlockGrid<3> grid(CellGeometry<3>(tree.getResolution()));
    std::vector<float> values(kBlockCells<3>);
    BlockView<3> block{{}, values.data(), {}};
    const auto flush = [&] {
        if (block.known.any()) grid.setBlock(block);
        block.known = {};
    };
    // Leaves come depth first, so those of a block come together.
    for (auto leaf = tree.begin_leafs(), end = tree.end_leafs(); leaf != end; ++leaf) {
        const octomap::OcTreeKey key = leaf.getIndexKey();
        const Cell<3> lowest{key[0] - kCellLimit, key[1] - kCellLimit, key[2] - kCellLimit};
        const std::int32_t edge = std::int32_t{1} << (tree.getTreeDepth() - leaf.getDepth());
        for (std::int32_t z = 0; z < edge; ++z)
            for (std::int32_t y = 0; y < edge; ++y)
                for (std::int32_t x = 0; x < edge; ++x) {
                    const Cell<3> cell{lowest[0] + x, lowest[1] + y, lowest[2] + z};
                    if (blockOf<3>(cell) != block.key) {
                        flush();
                        block.key = blockOf<3>(cell);
                    }
                    const int i = indexInBlock<3>(cell);
                    values[static_cast<std::size_t>(i)] = leaf->getLogOdds();
                    block.known.set(i);
                }
    }
    flush();
    return grid;
}

namespace {

class OctomapEngine final : public OctomapTreeEngine {
 public:
    using OctomapTreeEngine::OctomapTreeEngine;
    void insert() override { tree_.insertPointCloud(cloud_, origin_); }
};

}  // namespace

void listOctomapEngine(BenchEngineList& list) {
    list.push_back({"octomap", "liboctomap, OcTree::insertPointCloud()", false, "oncePerScan",
                    false, [](const BenchEngineOptions& options) {
                        return std::make_unique<OctomapEngine>(options);
                    }});
}

}  // namespace superray
