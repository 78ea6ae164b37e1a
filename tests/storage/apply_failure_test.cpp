// SPDX-License-Identifier: BSD-3-Clause
// When memory runs out in the middle of an update, the map stays whole, and every block
// is as it was or as it should become.

#include "storage/tree/octree_test_tools.h"

#include <superray/storage/block_grid.h>

#include <new>

#include "failing_allocations.h"

namespace superray::test {
namespace {

using BlockCells = std::map<BlockKey<3>, Cells<3>>;

BlockCells byBlock(const Cells<3>& cells) {
    BlockCells blocks;
    for (const auto& [cell, value] : cells) blocks[blockOf<3>(cell)][cell] = value;
    return blocks;
}

struct Failures {
    int failures = 0, blocksOld = 0, blocksNew = 0;
};

/// Allocations of at least `least` bytes that the second batch takes.
template <typename Map>
int allocationsOf(std::size_t least, const UpdateBatch<3>& first, const UpdateBatch<3>& second,
                  unsigned threads) {
    Map map{CellGeometry<3>(0.1)};
    map.apply(first, SensorModel(), UpdatePolicy::everyRay);
    allocations.leastSize = least;
    allocations.asked = 0;
    map.apply(second, SensorModel(), UpdatePolicy::everyRay, threads);
    return allocations.asked;
}

/// Lets more and more allocations of at least `least` bytes succeed while a batch is
/// applied, until it succeeds. \param isWhole(map, its cells, allowed) checks the map
template <typename Map, typename IsWhole>
void failMoreAndMoreLate(std::size_t least, unsigned threads, int mostAllowed, Failures& result,
                         const IsWhole& isWhole) {
    const SensorModel model;
    std::mt19937 random(77);
    bool succeeded = false;
    allocations.refused = 0;
    for (int allowed = 0; !succeeded; ++allowed) {
        ASSERT_LT(allowed, mostAllowed);
        Map map{CellGeometry<3>(0.1)};
        UpdateBatch<3> first, second;
        for (int i = 0; i < 200; ++i)
            addRandomBlock<3>(first, {i % 20 - 10, i / 20, i % 3}, static_cast<Fill>(i % 6),
                              random);
        for (int i = 0; i < 1100; ++i)
            addRandomBlock<3>(second, {i % 30 - 10, i / 30 - 20, i % 3},
                              static_cast<Fill>(1 + i % 5), random);
        // The first and last ones of all allocations, and some of those between.
        constexpr int kEnd = 8, kEach = 64;
        const int needed = allocationsOf<Map>(least, first, second, threads);
        if (allowed > kEnd && allowed < needed - kEnd && allowed % kEach != 0) continue;
        map.apply(first, model, UpdatePolicy::everyRay);
        const Cells<3> before = cellsOf<3>(map);
        Cells<3> after = before;
        applyToOracle(after, second, model, UpdatePolicy::everyRay);

        allocations.allowed = allowed;
        try {
            map.apply(second, model, UpdatePolicy::everyRay, threads);
            succeeded = true;
        } catch (const std::bad_alloc&) {
        }
        allocations.allowed = -1;
        const Cells<3> now = cellsOf<3>(map);
        isWhole(map, now, allowed);
        ASSERT_TRUE(saturationEquals<3>(map, now, model.min()));
        if (succeeded) {
            ASSERT_EQ(now, after);
            continue;
        }
        ++result.failures;
        BlockCells old = byBlock(before), all = byBlock(after), got = byBlock(now);
        for (const auto& [key, cells] : all) {
            ASSERT_TRUE(got[key] == cells || got[key] == old[key]) << allowed;
            if (cells != old[key]) ++(got[key] == cells ? result.blocksNew : result.blocksOld);
        }
        // And it works on, when there is memory again.
        map.apply(first, model, UpdatePolicy::everyRay, threads);
        Cells<3> expected = now;
        applyToOracle(expected, first, model, UpdatePolicy::everyRay);
        ASSERT_TRUE(equalsOracle<3>(map, expected)) << allowed;
    }
    EXPECT_GE(allocations.refused, result.failures);
    EXPECT_GT(result.blocksOld, 100);
    EXPECT_GT(result.blocksNew, 100);
}

class ApplyFailure : public ::testing::TestWithParam<unsigned> {};

TEST_P(ApplyFailure, EveryBlockOfATreeIsOldOrNew) {
    constexpr std::size_t kLarge = 60000;  // chunks of nodes, and few others
    Failures result;
    failMoreAndMoreLate<Octree>(kLarge, GetParam(), 100, result,
                                [](const Octree& map, const Cells<3>& now, int allowed) {
                                    ASSERT_TRUE(sameNodes(map.tree(), *octomapTree(now, 0.1)))
                                        << allowed;
                                });
    EXPECT_GT(result.failures, 4);
}

TEST_P(ApplyFailure, EveryBlockOfAGridIsOldOrNew) {
    Failures result;
    failMoreAndMoreLate<BlockGrid<3>>(0, GetParam(), 2000, result,
                                      [](const BlockGrid<3>&, const Cells<3>&, int) {});
    EXPECT_GT(result.failures, 15);
}

INSTANTIATE_TEST_SUITE_P(Threads, ApplyFailure, ::testing::Values(1u, 2u));

}  // namespace
}  // namespace superray::test
