// SPDX-License-Identifier: BSD-3-Clause
// The field equals brute force, after every change, at the cost of the change.

#include "queries/distance_field.h"

#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/storage/map_file.h>

#include <thread>

#include "maps/test_scans.h"
#include "matching/likelihood.h"

namespace superray {
namespace {

template <int Dim>
struct World {
    CellGeometry<Dim> geometry{0.1};
    std::unique_ptr<OccupancyMap<Dim>> map = makeStorage<Dim>(StorageType::blockGrid, geometry);
    ChangeLog<Dim> changes;
    SensorModel model;
    DistanceField<Dim> field;
    std::mt19937 random{11};

    typename DistanceField<Dim>::Source source() const {
        return {*map, changes, model.occupied()};
    }
    Cell<Dim> randomCell(int limit) {
        Cell<Dim> c;
        for (auto& v : c) v = std::uniform_int_distribution<int>(-limit, limit)(random);
        return c;
    }
    void set(const Cell<Dim>& c, float value) {
        changes.begin();
        changes.add(blockOf<Dim>(c));
        map->setLogOdds(c, value);
    }
    std::vector<Cell<Dim>> occupied() const {
        std::vector<Cell<Dim>> cells;
        map->forEachBlock([&](const BlockView<Dim>& block) {
            for (int i = 0; i < kBlockCells<Dim>; ++i)
                if (block.known.test(i) && block.values[i] >= model.occupied())
                    cells.push_back(cellInBlock<Dim>(block.key, i));
        });
        return cells;
    }

    /// \return cells that have an occupied one within reach
    std::size_t expectEqualsBruteForce(double reach, std::size_t queries, int limit) {
        const auto all = occupied();
        std::vector<Cell<Dim>> cells;
        for (std::size_t i = 0; i < queries; ++i) cells.push_back(randomCell(limit));
        std::vector<typename DistanceField<Dim>::Code> codes(queries);
        field.nearest(source(), reach, cells.data(), queries, codes.data());
        std::size_t found = 0;
        for (std::size_t i = 0; i < queries; ++i) {
            int best = 1 << 30;
            for (const auto& o : all) {
                int squared = 0;
                for (std::size_t a = 0; a < Dim; ++a)
                    squared += (o[a] - cells[i][a]) * (o[a] - cells[i][a]);
                best = std::min(best, squared);
            }
            EXPECT_EQ(codes[i].found(), best <= reach * reach);
            if (!codes[i].found()) continue;
            ++found;
            EXPECT_EQ(codes[i].squaredCells(), best);
            Cell<Dim> nearest = codes[i].offset();
            int squared = 0;
            for (std::size_t a = 0; a < Dim; ++a) {
                squared += nearest[a] * nearest[a];
                nearest[a] += cells[i][a];
            }
            EXPECT_EQ(squared, best);
            const auto value = map->logOdds(nearest);
            EXPECT_TRUE(value && *value >= model.occupied());
        }
        return found;
    }
};

template <int Dim>
void expectExactAfterChanges(double reach, int limit) {
    World<Dim> world;
    std::size_t found = 0;
    for (int round = 0; round < 12; ++round) {
        for (int i = 0; i < 25; ++i) {
            // Mostly new obstacles; some cells become free again.
            const auto cell = world.randomCell(limit);
            world.set(cell, i % 5 == 4 ? -1.0f : 1.0f);
            const auto all = world.occupied();
            if (i % 5 == 0) world.set(all[world.random() % all.size()], -0.5f);
        }
        found += world.expectEqualsBruteForce(reach, 400, limit + 8);
        if (::testing::Test::HasFailure()) FAIL() << "round " << round << ", reach " << reach;
    }
    EXPECT_GT(found, 50u);
    // All at once: cleared, and another rule for "occupied".
    world.model = SensorModel(SensorProbabilities{0.7, 0.4, 0.1192, 0.971, 0.35});
    EXPECT_GT(world.expectEqualsBruteForce(reach, 400, limit), 5u);
    world.map->clear();
    world.changes.everything();
    EXPECT_EQ(world.expectEqualsBruteForce(reach, 400, limit), 0u);
}

TEST(DistanceField, EqualsBruteForceAfterEveryChange) {
    expectExactAfterChanges<2>(3.2, 30);
    expectExactAfterChanges<2>(31, 100);
    expectExactAfterChanges<3>(1, 8);
    expectExactAfterChanges<3>(4.73, 12);
    expectExactAfterChanges<3>(17.5, 30);
    expectExactAfterChanges<3>(31, 40);
}

TEST(DistanceField, AChangeDropsOnlyWhatIsInReach) {
    World<3> world;
    for (int i = 0; i < 400; ++i) world.set(world.randomCell(60), 1.0f);
    world.expectEqualsBruteForce(4, 3000, 60);
    const std::size_t before = world.field.validBlocks();
    ASSERT_GT(before, 1000u);
    world.set({3, 3, 3}, 1.0f);
    world.expectEqualsBruteForce(4, 1, 2);  // brings it up to date near the origin
    EXPECT_GE(world.field.validBlocks(), before - 7) << "reach 4 from 3: one block further";
    EXPECT_LT(world.field.validBlocks(), before);
    // A free cell that stays free changes no distance.
    const std::size_t kept = world.field.validBlocks();
    world.set({20, 20, 20}, -1.0f);
    world.expectEqualsBruteForce(4, 1, 2);
    EXPECT_GE(world.field.validBlocks(), kept);
}

TEST(DistanceField, ReachGrowsOnDemand) {
    World<3> world;
    world.set({0, 0, 0}, 1.0f);
    EXPECT_GT(world.expectEqualsBruteForce(3, 200, 4), 20u);
    EXPECT_GT(world.expectEqualsBruteForce(12, 200, 14), 20u);
    EXPECT_EQ(DistanceField<3>::reachFor(100, 0.1), 31);
    EXPECT_NEAR(DistanceField<3>::reachFor(0.3, 0.1), 3 + std::sqrt(3.0), 1e-12);
}

TEST(DistanceField, ManyReadersOfAConstMapAgree) {
    CSuperRayGridMap3D map(0.1);
    ASSERT_TRUE(map.insertObservation(*test::randomCloud(3000, 5), test::someRobotPose()));
    const auto scan = test::randomCloud(500, 6);
    const CSuperRayGridMap3D& shared = map;
    std::vector<double> expected;
    const auto poseOf = [](int i) {
        return mrpt::poses::CPose3D(0.3 * i, -0.2 * i, 0.1 * i, 0.4 * i, 0, 0);
    };
    for (int i = 0; i < 12; ++i)
        expected.push_back(
            CSuperRayGridMap3D(map).computeObservationLikelihood(*scan, poseOf(i)));
    std::vector<std::vector<double>> got(4, std::vector<double>(12));
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < got.size(); ++t)
        threads.emplace_back([&, t] {
            for (int i = 0; i < 12; ++i)
                got[t][static_cast<std::size_t>(i)] =
                    shared.computeObservationLikelihood(*scan, poseOf(i));
        });
    for (auto& thread : threads) thread.join();
    for (const auto& result : got) EXPECT_EQ(result, expected);
}

TEST(ChangeLog, VisitsWhatChangedSince) {
    ChangeLog<2> log;
    log.begin();
    log.add({9, 9});  // nobody follows yet
    const auto start = log.stamp();
    const auto since = [&](std::uint64_t stamp) {
        std::vector<BlockKey<2>> keys;
        EXPECT_TRUE(log.forEachSince(stamp, [&](const auto& key) { keys.push_back(key); }));
        std::sort(keys.begin(), keys.end());
        return keys;
    };
    EXPECT_TRUE(since(start).empty());
    log.begin();
    log.add({1, 2});
    const auto middle = log.stamp();
    log.begin();
    log.add({1, 2});
    log.add({3, 4});
    EXPECT_EQ(since(start), (std::vector<BlockKey<2>>{{1, 2}, {3, 4}}));
    EXPECT_EQ(since(middle), (std::vector<BlockKey<2>>{{1, 2}, {3, 4}}));
    EXPECT_TRUE(since(log.stamp()).empty());
    for (int i = 0; i < 40000; ++i) {
        log.begin();
        log.add({i % 7, 0});
    }
    EXPECT_EQ(since(middle).size(), 9u) << "old entries are dropped, not forgotten";
    log.everything();
    EXPECT_FALSE(log.forEachSince(middle, [](const auto&) {}));
    EXPECT_TRUE(since(log.stamp()).empty());
    EXPECT_FALSE(log.forEachSince(start - 1, [](const auto&) {}));
}

TEST(ChangeLog, OfAMap) {
    CSuperRayGridMap3D map(0.1);
    ASSERT_TRUE(map.insertObservation(*test::randomCloud(50, 1)));
    const auto stamp = map.changeStamp();
    EXPECT_TRUE(map.forEachChangedBlock(stamp, [](const auto&) { FAIL(); }));
    const CSuperRayGridMap3D before(map);
    for (const Method method : {Method::full, Method::reference}) {
        map.insertionOptions.method = method;
        const auto since = map.changeStamp();
        ASSERT_TRUE(map.insertObservation(*test::randomCloud(20, 2)));
        EXPECT_GT(map.changeStamp(), since);
        std::vector<BlockKey<3>> changed;
        ASSERT_TRUE(
            map.forEachChangedBlock(since, [&](const auto& key) { changed.push_back(key); }));
        ASSERT_GT(changed.size(), 5u);
    }
    std::vector<BlockKey<3>> changed;
    map.forEachChangedBlock(stamp, [&](const auto& key) { changed.push_back(key); });
    // What is not among them is as it was.
    std::size_t same = 0;
    map.storage().forEachBlock([&](const BlockView<3>& block) {
        if (std::find(changed.begin(), changed.end(), block.key) != changed.end()) return;
        for (int i = 0; i < kBlockCells<3>; ++i) {
            if (!block.known.test(i)) continue;
            EXPECT_EQ(before.storage().logOdds(cellInBlock<3>(block.key, i)), block.values[i]);
            ++same;
        }
    });
    EXPECT_GT(same, 100u);
    map.clear();
    EXPECT_FALSE(map.forEachChangedBlock(stamp, [](const auto&) {}));
}

}  // namespace
}  // namespace superray
