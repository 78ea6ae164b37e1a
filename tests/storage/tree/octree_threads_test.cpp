// SPDX-License-Identifier: BSD-3-Clause
// Threads change nothing: the same nodes, whoever makes them.

#include "storage/tree/octree_test_tools.h"

namespace superray::test {
namespace {

class OctreeThreads : public ::testing::TestWithParam<unsigned> {
 protected:
    Octree one{CellGeometry<3>(0.1)}, many{CellGeometry<3>(0.1)};
    SensorModel model;
    std::mt19937 random{20240229};

    void applyToBoth(const UpdateBatch<3>& batch,
                     UpdatePolicy policy = UpdatePolicy::everyRay) {
        ASSERT_GE(batch.blockCount(), 512u * 4) << "too few to be shared out";
        one.apply(batch, model, policy, 1);
        many.apply(batch, model, policy, GetParam());
    }
    void expectSame() const {
        ASSERT_TRUE(sameNodes(many.tree(), one.tree()));
        ASSERT_EQ(many.memoryBytes(), one.memoryBytes());
    }
    /// Some of the blocks of a box, in random order.
    UpdateBatch<3> box(const BlockKey<3>& lowest, int edge, unsigned percent, int fills) {
        std::vector<BlockKey<3>> keys;
        for (int x = 0; x < edge; ++x)
            for (int y = 0; y < edge; ++y)
                for (int z = 0; z < edge; ++z)
                    if (random() % 100 < percent)
                        keys.push_back({lowest[0] + x, lowest[1] + y, lowest[2] + z});
        std::shuffle(keys.begin(), keys.end(), random);
        UpdateBatch<3> batch;
        for (const auto& key : keys)
            addRandomBlock<3>(batch, key, static_cast<Fill>(random() % unsigned(fills)),
                              random);
        return batch;
    }
};

TEST_P(OctreeThreads, ManyScans) {
    Cells<3> oracle;
    for (int scan = 0; scan < 3; ++scan) {
        const auto policy = kUpdatePolicies[scan % 3];
        // Moving on: some blocks are new, some nodes of subtrees, too.
        const auto batch = box({5 * scan - 20, -9, -8}, 16, 55, 6);
        applyToBoth(batch, policy);
        applyToOracle(oracle, batch, model, policy);
        expectSame();
        EXPECT_EQ(contentDigest(one), contentDigest(many));
    }
    EXPECT_GT(many.tree().size(), 300000u);
    EXPECT_TRUE(sameNodes(many.tree(), *octomapTree(oracle, 0.1)));
    for (Octree* map : {&one, &many})
        EXPECT_TRUE(saturationEquals<3>(*map, oracle, model.min()));
}

TEST_P(OctreeThreads, LeavesLargerThanWhatThreadsShareOutAreMadeAndSplit) {
    UpdateBatch<3> misses;
    for (int x = -16; x < 16; ++x)
        for (int y = 0; y < 16; ++y)
            for (int z = -16; z < 0; ++z)
                addRandomBlock<3>(misses, {x, y, z}, Fill::saturating, random);
    applyToBoth(misses);
    expectSame();
    EXPECT_LT(many.tree().size(), 100u) << "2 leaves of 16^3 blocks and the way to them";

    const auto hits = box({-20, -4, -12}, 16, 70, 6);
    for (int scan = 0; scan < 2; ++scan) {
        applyToBoth(hits);
        expectSame();
        EXPECT_GT(many.tree().size(), 100000u);
        applyToBoth(misses);
        expectSame();
    }
}

TEST_P(OctreeThreads, BlocksWithoutTouchedCellsLeaveNoTrace) {
    UpdateBatch<3> batch;
    for (int i = 0; i < 4096; ++i) {
        const auto b = batch.addBlock({i % 64, i / 64, 3});
        batch.hitsOf(b);
    }
    applyToBoth(batch);
    EXPECT_TRUE(many.empty());
    EXPECT_EQ(many.tree().size(), 0u);
    batch.missesOf(1000)[5] = 1;
    applyToBoth(batch);
    expectSame();
    EXPECT_EQ(many.tree().size(), 17u);
}

TEST_P(OctreeThreads, ThreadsMayChangeFromScanToScan) {
    for (unsigned scan = 0; scan < 4; ++scan) {
        const auto batch = box({-8, -8, -8}, 16, 60, 6);
        ASSERT_GE(batch.blockCount(), 2048u);
        one.apply(batch, model, UpdatePolicy::everyRay, 1);
        many.apply(batch, model, UpdatePolicy::everyRay, 1 + (scan + GetParam()) % 4);
        expectSame();
        const Octree copy(many);
        ASSERT_TRUE(sameNodes(copy.tree(), one.tree()));
    }
}

INSTANTIATE_TEST_SUITE_P(Threads, OctreeThreads, ::testing::Values(2u, 3u, 8u));

}  // namespace
}  // namespace superray::test
