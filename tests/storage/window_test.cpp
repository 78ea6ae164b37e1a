// SPDX-License-Identifier: BSD-3-Clause
// Forgetting what is outside a window, and knowing beforehand what an update takes.

#include "storage/storage_test_tools.h"
#include "storage/tree/octree_test_tools.h"

#include <cmath>
#include <limits>
#include <set>

namespace superray::test {
namespace {

/// By definition: the gap between the boxes of two blocks [m].
template <int Dim>
double gapBetween(const BlockKey<Dim>& a, const BlockKey<Dim>& b, double blockEdge) {
    double squared = 0;
    for (std::size_t i = 0; i < Dim; ++i) {
        const double low = std::max(a[i], b[i]), high = std::min(a[i], b[i]) + 1;
        const double gap = std::max(0.0, low - high);
        squared += gap * gap;
    }
    return std::sqrt(squared) * blockEdge;
}

template <typename Case>
class Window : public ::testing::Test {
 protected:
    static constexpr int kDim = Case::Dim;
    static constexpr double kResolution = 0.25;  // blocks of 2 m: sums are exact
    static constexpr double kBlockEdge = kResolution * superray::kBlockEdge;
    CellGeometry<kDim> geometry{kResolution};
    typename Case::Map map{geometry};
    SensorModel model;
    std::mt19937 random{20240611};
    Cells<kDim> oracle;

    BlockKey<kDim> keyNear(const BlockKey<kDim>& center, int reach) {
        BlockKey<kDim> key;
        for (std::size_t a = 0; a < kDim; ++a)
            key[a] = center[a] - reach +
                     static_cast<std::int32_t>(random() % unsigned(2 * reach + 1));
        return key;
    }
    /// Random blocks around one, and a solid cube of them, which trees prune.
    UpdateBatch<kDim> scanAround(const BlockKey<kDim>& center, int reach, int blocks) {
        UpdateBatch<kDim> batch;
        std::set<BlockKey<kDim>> used;
        for (int b = 0; b < blocks; ++b) {
            const BlockKey<kDim> key = keyNear(center, reach);
            if (used.insert(key).second)
                addRandomBlock<kDim>(batch, key, static_cast<Fill>(random() % 6), random);
        }
        for (int i = 0; i < 1 << (2 * kDim); ++i) {
            BlockKey<kDim> key = center;
            for (std::size_t a = 0; a < kDim; ++a)
                key[a] = (center[a] & ~3) + ((i >> (2 * a)) & 3);
            if (used.insert(key).second)
                addRandomBlock<kDim>(batch, key, Fill::allMissed, random);
        }
        return batch;
    }
    void applyToBoth(const UpdateBatch<kDim>& batch, unsigned threads = 1) {
        map.apply(batch, model, UpdatePolicy::everyRay, threads);
        applyToOracle(oracle, batch, model, UpdatePolicy::everyRay);
    }
    /// Forgets in the map and, by definition, in the oracle. \return blocks forgotten
    std::size_t forget(const BlockKey<kDim>& sensor, double radius) {
        std::set<BlockKey<kDim>> expected, told;
        for (auto it = oracle.begin(); it != oracle.end();) {
            const BlockKey<kDim> key = blockOf<kDim>(it->first);
            if (gapBetween<kDim>(key, sensor, kBlockEdge) > radius) {
                expected.insert(key);
                it = oracle.erase(it);
            } else {
                ++it;
            }
        }
        const BlockWindow<kDim> window(sensor, radius, kResolution);
        map.forgetOutside(window, [&](const BlockKey<kDim>& key) {
            EXPECT_TRUE(told.insert(key).second) << "told twice";
        });
        EXPECT_EQ(told, expected);
        return expected.size();
    }
    void expectEqual() {
        ASSERT_TRUE(equalsOracle<kDim>(map, oracle));
        ASSERT_TRUE(saturationEquals<kDim>(map, oracle, model.min()));
        EXPECT_EQ(map.empty(), oracle.empty());
        if constexpr (std::is_same_v<typename Case::Map, Octree>) {
            EXPECT_TRUE(sameNodes(map.tree(), *octomapTree(oracle, kResolution)));
        }
    }
};
TYPED_TEST_SUITE(Window, AllStorages);

TYPED_TEST(Window, ForgetsByDefinitionWhileTheSensorMoves) {
    constexpr int Dim = TypeParam::Dim;
    std::size_t forgotten = 0, kept = 0;
    BlockKey<Dim> sensor{};
    for (int scan = 0; scan < 60; ++scan) {
        for (std::size_t a = 0; a < Dim; ++a)
            sensor[a] += static_cast<std::int32_t>(this->random() % 4) - 1;
        this->applyToBoth(this->scanAround(sensor, 5, 40), scan % 3 == 0 ? 3 : 1);
        const double radius = 0.5 * static_cast<double>(this->random() % 20);
        forgotten += this->forget(sensor, radius);
        this->expectEqual();
        kept += this->oracle.size();
    }
    EXPECT_GT(forgotten, 300u);
    EXPECT_GT(kept, 10000u);
}

TYPED_TEST(Window, FarthestBlocksAndEmptyMaps) {
    constexpr int Dim = TypeParam::Dim;
    constexpr double kForever = std::numeric_limits<double>::infinity();
    EXPECT_EQ(this->forget({}, 0), 0u);
    this->applyToBoth(randomBatch<Dim>(this->random, 40));  // some at the addressable limit
    EXPECT_EQ(this->forget({}, kForever), 0u);
    this->expectEqual();
    EXPECT_GT(this->forget({}, 100), 0u);
    this->expectEqual();
    BlockKey<Dim> corner;
    corner.fill(kCellLimit / kBlockEdge - 1);
    EXPECT_GT(this->forget(corner, 0), 0u);
    EXPECT_TRUE(this->map.empty());
    this->expectEqual();
    this->applyToBoth(this->scanAround({}, 3, 20));
    this->expectEqual();
}

TYPED_TEST(Window, NeighboursTouchAndTheBorderIsInside) {
    constexpr int Dim = TypeParam::Dim;
    const BlockWindow<Dim> window({}, 6, this->kResolution);  // 3 blocks
    BlockKey<Dim> key{};
    key[0] = 4;  // blocks 1, 2 and 3 are between: 6 m
    EXPECT_TRUE(window.holds(key));
    key[1] = -1;  // touches the row beside it: no gap along that axis
    EXPECT_TRUE(window.holds(key));
    key[1] = -2;
    EXPECT_FALSE(window.holds(key));
    key = {};
    key[0] = -5;
    EXPECT_FALSE(window.holds(key));
    EXPECT_TRUE((BlockWindow<Dim>({}, 0, 1).holds({})));
}

TYPED_TEST(Window, MemoryIsFlatAlongALongWay) {
    constexpr int Dim = TypeParam::Dim;
    std::size_t afterFirst = 0;
    for (int scan = 0; scan < 300; ++scan) {
        BlockKey<Dim> sensor{};
        sensor[0] = 2 * scan - 300;
        this->map.apply(this->scanAround(sensor, 4, 30), this->model, UpdatePolicy::everyRay,
                        1);
        this->map.forgetOutside(BlockWindow<Dim>(sensor, 8, this->kResolution),
                                [](const BlockKey<Dim>&) {});
        if (scan == 99) afterFirst = this->map.heldBytes();
    }
    // Random scans: the greatest need is seldom met early.
    EXPECT_LE(this->map.heldBytes(), afterFirst * 5 / 4);
    EXPECT_LE(this->map.memoryBytes(), this->map.heldBytes() + 4096);
}

/// What an update takes is known before, and not much overestimated.
TYPED_TEST(Window, HeldBytesAreForetold) {
    constexpr int Dim = TypeParam::Dim;
    using Visitor = typename OccupancyMap<Dim>::BlockVisitor;
    double foretold = 0, became = 0;
    BlockKey<Dim> sensor{};
    for (int scan = 0; scan < 80; ++scan) {
        sensor[0] = scan;
        const auto batch = this->scanAround(sensor, 6, scan % 7 == 0 ? 400 : 60);
        const auto policy = scan % 2 == 0 ? UpdatePolicy::netEvidence : UpdatePolicy::everyRay;
        const std::size_t held = this->map.heldBytes();
        const std::size_t most = this->map.heldBytesWith([&](const Visitor& visit) {
            this->map.forEachWritten(batch, this->model, policy, visit);
        });
        EXPECT_LE(most, this->map.heldBytesAtMost(batch.blockCount(), 1));
        this->map.apply(batch, this->model, policy, 1);
        ASSERT_LE(this->map.heldBytes(), most) << "scan " << scan;
        ASSERT_GE(most, held);
        foretold += static_cast<double>(most);
        became += static_cast<double>(this->map.heldBytes());
        if (scan % 5 == 4)
            this->map.forgetOutside(BlockWindow<Dim>(sensor, 12, this->kResolution),
                                    [](const BlockKey<Dim>&) {});
    }
    EXPECT_LT(foretold, (Dim == 3 ? 1.25 : 2.5) * became + 80 * 65536);
}

TYPED_TEST(Window, WrittenBlocksHaveTheValuesToCome) {
    constexpr int Dim = TypeParam::Dim;
    for (int scan = 0; scan < 10; ++scan) {
        const auto batch = randomBatch<Dim>(this->random, 12);
        const Cells<Dim> before = cellsOf<Dim>(this->map);
        this->applyToBoth(UpdateBatch<Dim>());
        Cells<Dim> expected = before;
        this->map.forEachWritten(
            batch, this->model, UpdatePolicy::everyRay, [&](const BlockView<Dim>& block) {
                for (int i = 0; i < kBlockCells<Dim>; ++i)
                    if (block.known.test(i))
                        expected[cellInBlock<Dim>(block.key, i)] = block.values[i];
            });
        this->applyToBoth(batch);
        EXPECT_TRUE(equalsOracle<Dim>(this->map, expected));
    }
}

/// With threads and many blocks, the coarse bound holds.
TYPED_TEST(Window, CoarseBoundHoldsWithThreads) {
    constexpr int Dim = TypeParam::Dim;
    for (int scan = 0; scan < 4; ++scan) {
        const auto batch = this->scanAround({}, Dim == 3 ? 8 : 30, 3000);
        const std::size_t most = this->map.heldBytesAtMost(batch.blockCount(), 3);
        this->map.apply(batch, this->model, UpdatePolicy::everyRay, 3);
        EXPECT_LE(this->map.heldBytes(), most);
    }
    EXPECT_GT(this->map.heldBytes(), 100000u);
}

}  // namespace
}  // namespace superray::test
