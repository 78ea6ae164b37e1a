// When memory runs out in the middle of an update, the tree stays a tree, and
// every block is as it was or as it should become.

#include "storage/octree_test_tools.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
/// Allocations of at least this size fail once so many have succeeded.
constexpr std::size_t kLarge = 60000;  // chunks of nodes, and few others
std::atomic<int> largeAllowed{-1};     // -1: no limit
std::atomic<int> refused{0};
}  // namespace

[[gnu::noinline]] void* operator new(std::size_t bytes) {
    if (bytes >= kLarge && largeAllowed >= 0 && largeAllowed.fetch_sub(1) <= 0) {
        largeAllowed = 0;
        ++refused;
        throw std::bad_alloc();
    }
    if (void* const p = std::malloc(bytes)) return p;
    throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept {
    std::free(p);
}
// Sanitizers have their own of these.
void* operator new[](std::size_t bytes) {
    return operator new(bytes);
}
void operator delete[](void* p) noexcept {
    operator delete(p);
}
void operator delete(void* p, std::size_t) noexcept {
    operator delete(p);
}
void operator delete[](void* p, std::size_t) noexcept {
    operator delete(p);
}

namespace superray::test {
namespace {

using BlockCells = std::map<BlockKey<3>, Cells<3>>;

BlockCells byBlock(const Cells<3>& cells) {
    BlockCells blocks;
    for (const auto& [cell, value] : cells) blocks[blockOf<3>(cell)][cell] = value;
    return blocks;
}

class OctreeFailure : public ::testing::TestWithParam<unsigned> {};

TEST_P(OctreeFailure, EveryBlockIsOldOrNew) {
    const SensorModel model;
    std::mt19937 random(77);
    int failures = 0, blocksOld = 0, blocksNew = 0;
    bool succeeded = false;
    for (int allowed = 0; !succeeded; ++allowed) {
        ASSERT_LT(allowed, 100);
        Octree map{CellGeometry<3>(0.1)};
        UpdateBatch<3> first, second;
        for (int i = 0; i < 200; ++i)
            addRandomBlock<3>(first, {i % 20 - 10, i / 20, i % 3}, static_cast<Fill>(i % 6),
                              random);
        for (int i = 0; i < 1100; ++i)
            addRandomBlock<3>(second, {i % 30 - 10, i / 30 - 20, i % 3},
                              static_cast<Fill>(1 + i % 5), random);
        map.apply(first, model, UpdatePolicy::everyRay);
        const Cells<3> before = cellsOf<3>(map);
        Cells<3> after = before;
        applyToOracle(after, second, model, UpdatePolicy::everyRay);

        largeAllowed = allowed;
        try {
            map.apply(second, model, UpdatePolicy::everyRay, GetParam());
            succeeded = true;
        } catch (const std::bad_alloc&) {
        }
        largeAllowed = -1;
        const Cells<3> now = cellsOf<3>(map);
        ASSERT_TRUE(sameNodes(map.tree(), *octomapTree(now, 0.1))) << allowed;
        ASSERT_TRUE(saturationEquals<3>(map, now, model.min()));
        if (succeeded) {
            ASSERT_EQ(now, after);
            continue;
        }
        ++failures;
        BlockCells old = byBlock(before), all = byBlock(after), got = byBlock(now);
        for (const auto& [key, cells] : all) {
            ASSERT_TRUE(got[key] == cells || got[key] == old[key]) << allowed;
            if (cells != old[key]) ++(got[key] == cells ? blocksNew : blocksOld);
        }
        // And it works on, when there is memory again.
        map.apply(first, model, UpdatePolicy::everyRay, GetParam());
        Cells<3> expected = now;
        applyToOracle(expected, first, model, UpdatePolicy::everyRay);
        ASSERT_TRUE(equalsOracle<3>(map, expected));
    }
    EXPECT_GT(failures, 4);
    EXPECT_GE(refused, failures);
    EXPECT_GT(blocksOld, 100);
    EXPECT_GT(blocksNew, 100);
}

INSTANTIATE_TEST_SUITE_P(Threads, OctreeFailure, ::testing::Values(1u, 2u));

}  // namespace
}  // namespace superray::test
