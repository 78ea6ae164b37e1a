// SPDX-License-Identifier: BSD-3-Clause
// The octree is, node by node, the tree that OctoMap would have built.

#include "storage/tree/octree_test_tools.h"

#include <limits>

namespace superray::test {
namespace {

class OctreeAgainstOctomap : public ::testing::Test {
 protected:
    Octree map{CellGeometry<3>(0.1)};
    SensorModel model;
    std::mt19937 random{3};
    Cells<3> oracle;

    void apply(const UpdateBatch<3>& batch, UpdatePolicy policy = UpdatePolicy::everyRay) {
        map.apply(batch, model, policy);
        applyToOracle(oracle, batch, model, policy);
    }
    ::testing::AssertionResult sameAsOctomap() const {
        return sameNodes(map.tree(), *octomapTree(oracle, 0.1));
    }
};

TEST_F(OctreeAgainstOctomap, RandomScans) {
    for (const auto policy : kUpdatePolicies)
        for (int scan = 0; scan < 25; ++scan) {
            apply(randomBatch<3>(random, 12), policy);
            ASSERT_TRUE(sameAsOctomap()) << "scan " << scan;
        }
    EXPECT_GT(map.tree().size(), 10000u);
}

TEST_F(OctreeAgainstOctomap, OneCellPerScan) {
    for (int scan = 0; scan < 300; ++scan) {
        UpdateBatch<3> batch;
        const auto b = batch.addBlock(randomKey<3>(random));
        batch.missesOf(b)[random() % 512] = 1;
        apply(batch);
    }
    EXPECT_TRUE(sameAsOctomap());
}

TEST_F(OctreeAgainstOctomap, LargeFreeSpaceIsPrunedAboveBlocksAndSplitAgain) {
    UpdateBatch<3> misses;
    for (int x = -4; x < 4; ++x)
        for (int y = -4; y < 4; ++y)
            for (int z = 0; z < 4; ++z)
                addRandomBlock<3>(misses, {x, y, z}, Fill::saturating, random);
    apply(misses);
    ASSERT_TRUE(sameAsOctomap());
    EXPECT_LT(map.tree().size(), 100u) << "4 leaves of 4^3 blocks and the way to them";

    const std::size_t size = map.tree().size();
    apply(misses);
    EXPECT_EQ(map.tree().size(), size) << "misses of saturated cells split nothing";
    EXPECT_TRUE(saturationEquals<3>(map, oracle, model.min()));

    UpdateBatch<3> hit;
    hit.hitsOf(hit.addBlock({1, 1, 1}))[100] = 1;
    apply(hit);
    EXPECT_GT(map.tree().size(), size);
    EXPECT_TRUE(sameAsOctomap());
    EXPECT_TRUE(saturationEquals<3>(map, oracle, model.min()));

    apply(misses);  // the hit cell is free again
    EXPECT_EQ(map.tree().size(), size);
    EXPECT_TRUE(sameAsOctomap());
}

TEST_F(OctreeAgainstOctomap, SetLogOddsAndSetBlock) {
    apply(randomBatch<3>(random, 12));
    for (int i = 0; i < 500; ++i) {
        const auto cell =
            cellInBlock<3>(randomKey<3>(random), static_cast<int>(random() % 512));
        const float value = float(random() % 4) - 2.0f;
        map.setLogOdds(cell, value);
        oracle[cell] = value;
    }
    std::array<float, 512> values;
    for (int b = 0; b < 30; ++b) {
        BlockView<3> view{randomKey<3>(random), values.data(), {}};
        for (int i = 0; i < 512; ++i) {
            values[static_cast<std::size_t>(i)] = b % 3 ? 1.25f : float(random() % 2);
            if (b % 2 && random() % 4 == 0) continue;
            view.known.set(i);
            oracle[cellInBlock<3>(view.key, i)] = values[static_cast<std::size_t>(i)];
        }
        map.setBlock(view);
    }
    EXPECT_TRUE(sameAsOctomap());
}

TEST_F(OctreeAgainstOctomap, LowestFloatIsAValueAndNotAnAbsentNode) {
    const float lowest = std::numeric_limits<float>::lowest();
    for (int missing = 0; missing < 8; ++missing)
        for (int i = 0; i < 8; ++i) {
            if (i == missing) continue;
            const Cell<3> cell{2 * missing + (i & 1), i >> 1 & 1, i >> 2};
            map.setLogOdds(cell, lowest);
            oracle[cell] = lowest;
        }
    EXPECT_EQ(oracle.size(), 56u);
    EXPECT_TRUE(equalsOracle<3>(map, oracle));  // OctoMap would clamp such a value
    UpdateBatch<3> misses;
    misses.missesOf(misses.addBlock({}))[9] = 1;
    apply(misses);
    EXPECT_TRUE(equalsOracle<3>(map, oracle));
}

// OctoMap's own update: one miss or hit per cell and scan, by updateNode().
TEST_F(OctreeAgainstOctomap, OncePerScanEqualsUpdateNode) {
    octomap::OcTree theirs(0.1);
    const SensorProbabilities p = model.probabilities();
    theirs.setProbHit(p.probHit);
    theirs.setProbMiss(p.probMiss);
    theirs.setClampingThresMin(p.clampMin);
    theirs.setClampingThresMax(p.clampMax);
    int updates = 0;
    for (int scan = 0; scan < 30; ++scan) {
        const auto batch = randomBatch<3>(random, 8);
        apply(batch, UpdatePolicy::oncePerScan);
        for (std::size_t b = 0; b < batch.blockCount(); ++b)
            for (int i = 0; i < 512; ++i) {
                const bool hit = batch.hits(b) && batch.hits(b)[i];
                if (!hit && !batch.misses(b)[i]) continue;
                theirs.updateNode(keyOf(cellInBlock<3>(batch.key(b), i)), hit);
                ++updates;
            }
    }
    EXPECT_GT(updates, 20000);
    EXPECT_TRUE(sameNodes(map.tree(), theirs));
}

TEST_F(OctreeAgainstOctomap, TreeFollowsTheSensorModel) {
    SensorProbabilities p;
    p.occupancyThreshold = 0.8;
    model = SensorModel(p);
    apply(randomBatch<3>(random, 12));
    EXPECT_EQ(map.tree().getOccupancyThresLog(), model.occupied());
    EXPECT_EQ(map.tree().getProbHitLog(), model.hit());
    EXPECT_EQ(map.tree().getProbMissLog(), model.miss());
    EXPECT_EQ(map.tree().getClampingThresMinLog(), model.min());
    EXPECT_EQ(map.tree().getClampingThresMaxLog(), model.max());
    std::uint64_t occupied = 0;
    for (const auto& [cell, value] : oracle)
        occupied += map.tree().isNodeOccupied(map.tree().search(keyOf(cell)));
    EXPECT_EQ(occupied, summarize(map, model).occupied);
    EXPECT_GT(occupied, 100u);
}

TEST_F(OctreeAgainstOctomap, TreeReferenceAndBoundsSurviveSwapAndClear) {
    const octomap::OcTree& tree = map.tree();
    apply(randomBatch<3>(random, 12));
    Octree other{CellGeometry<3>(0.1)};
    other.setLogOdds({5, 6, 7}, 1.0f);
    map.swapContents(other);
    EXPECT_EQ(&tree, &map.tree());
    ASSERT_NE(tree.search(keyOf({5, 6, 7})), nullptr);
    double x, y, z;
    tree.getMetricMin(x, y, z);
    EXPECT_NEAR(x, 0.5, 1e-6);
    map.clear();
    EXPECT_EQ(&tree, &map.tree());
    EXPECT_EQ(tree.size(), 0u);
}

TEST_F(OctreeAgainstOctomap, MemoryIsTheTreesAndLittleMore) {
    for (int scan = 0; scan < 25; ++scan) apply(randomBatch<3>(random, 12));
    EXPECT_GE(map.memoryBytes(), map.tree().memoryUsage());
    EXPECT_LT(map.memoryBytes(), map.tree().memoryUsage() * 105 / 100 + 8192);
}

}  // namespace
}  // namespace superray::test
