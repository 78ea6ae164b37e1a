// SPDX-License-Identifier: BSD-3-Clause
// Nearest neighbours equal brute force over the centres of the occupied cells.

#include "queries/neighbor_search.h"

#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/storage/map_file.h>

#include <random>
#include <thread>

#include "maps/test_scans.h"

namespace superray {
namespace {

/// Every point of the map with its distance, sorted, without any index.
template <int Dim>
std::vector<Neighbor> bruteForce(const OccupancyMap<Dim>& map, float occupied,
                                 const NeighborQuery& query) {
    std::vector<Neighbor> all;
    map.forEachBlock([&](const BlockView<Dim>& block) {
        for (int i = 0; i < kBlockCells<Dim>; ++i) {
            if (!block.known.test(i) || block.values[i] < occupied) continue;
            const Cell<Dim> cell = cellInBlock<Dim>(block.key, i);
            Neighbor n;
            n.id = 0;
            float at[3] = {0, 0, 0};
            double center[3] = {0, 0, 0};
            double squared = 0;
            for (int a = 0; a < Dim; ++a) {
                const auto axis = static_cast<std::size_t>(a);
                center[a] = map.geometry().center(cell)[a];
                at[a] = static_cast<float>(center[a]);
                n.id += static_cast<std::uint64_t>(cell[axis] + 32768) * (1ull << (16 * a));
            }
            const int axes = query.distance == NeighborDistance::fromAbove ? 2 : 3;
            for (int a = 0; a < axes; ++a) {
                const double gap = center[a] - query.point[a];
                squared += gap * gap;
            }
            n.point = {at[0], at[1], at[2]};
            n.squaredDistance = squared;
            if (squared <= query.squaredRadius) all.push_back(n);
        }
    });
    std::sort(all.begin(), all.end(), [](const Neighbor& a, const Neighbor& b) {
        return a.squaredDistance != b.squaredDistance ? a.squaredDistance < b.squaredDistance
                                                      : a.id < b.id;
    });
    if (all.size() > query.most) all.resize(query.most);
    return all;
}

void expectSame(const std::vector<Neighbor>& found, const std::vector<Neighbor>& expected) {
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].id, expected[i].id) << i;
        EXPECT_EQ(found[i].squaredDistance, expected[i].squaredDistance) << i;
        EXPECT_EQ(found[i].point, expected[i].point) << i;
    }
}

template <int Dim>
struct World {
    CellGeometry<Dim> geometry{0.1};
    std::unique_ptr<OccupancyMap<Dim>> map = makeStorage<Dim>(StorageType::blockGrid, geometry);
    ChangeLog<Dim> changes;
    float occupied = SensorModel{}.occupied();
    DistanceField<Dim> field;
    std::mt19937 random{23};

    void set(const Cell<Dim>& c, float value) {
        changes.begin();
        changes.add(blockOf<Dim>(c));
        map->setLogOdds(c, value);
    }
    /// Cells within `limit` of the middle, some of them free.
    void fill(int cells, int limit) {
        std::uniform_int_distribution<int> coordinate(-limit, limit);
        for (int i = 0; i < cells; ++i) {
            Cell<Dim> c;
            for (auto& v : c) v = coordinate(random);
            set(c, i % 4 == 0 ? -1.0f : 2.0f);
        }
    }
    NeighborQuery randomQuery(double limit) {
        std::uniform_real_distribution<double> at(-limit, limit), share(0, 1);
        NeighborQuery query;
        query.point = {at(random), at(random), at(random)};
        // On corners and centres of cells many points are equally far.
        if (share(random) < 0.3)
            query.point = (query.point / 0.1).array().round().matrix() * 0.1;
        else if (share(random) < 0.3)
            query.point = ((query.point / 0.1).array().floor() + 0.5).matrix() * 0.1;
        if (share(random) < 0.3) query.distance = NeighborDistance::fromAbove;
        const double kind = share(random);
        if (kind < 0.7)
            query.most = static_cast<std::size_t>(1 + share(random) * share(random) * 40);
        if (kind > 0.5) query.squaredRadius = share(random) * share(random) * limit * limit;
        return query;
    }
    std::size_t expectEqualsBruteForce(int queries, double limit) {
        std::size_t found = 0;
        for (int i = 0; i < queries; ++i) {
            SCOPED_TRACE(i);
            const NeighborQuery query = randomQuery(limit);
            const auto result = findNeighbors<Dim>(field, {*map, changes, occupied}, query);
            expectSame(result, bruteForce<Dim>(*map, occupied, query));
            found += result.size();
        }
        return found;
    }
};

template <int Dim>
void checkAgainstBruteForce() {
    {
        World<Dim> dense;
        dense.fill(4000, Dim == 2 ? 60 : 20);
        EXPECT_GT(dense.expectEqualsBruteForce(300, Dim == 2 ? 8 : 3), 3000u);
        // Changes, small ones too, are followed.
        for (int round = 0; round < 5; ++round) {
            dense.fill(7, 15);
            EXPECT_GT(dense.expectEqualsBruteForce(30, 2), 100u);
        }
    }
    World<Dim> sparse;
    EXPECT_EQ(sparse.expectEqualsBruteForce(20, 5), 0u);
    sparse.fill(60, 1500);
    EXPECT_GT(sparse.expectEqualsBruteForce(300, 200), 300u);
}

TEST(NeighborSearch, equalsBruteForce2D) {
    checkAgainstBruteForce<2>();
}
TEST(NeighborSearch, equalsBruteForce3D) {
    checkAgainstBruteForce<3>();
}

/// A filled block of cells: all rings are looked up, none is skipped.
TEST(NeighborSearch, equalsBruteForceInSolidMatter) {
    World<3> world;
    for (int z = -14; z < 14; ++z)
        for (int y = -14; y < 14; ++y)
            for (int x = -30; x < 30; ++x) world.set({x, y, z}, 2.0f);
    EXPECT_GT(world.expectEqualsBruteForce(40, 4), 1000u);
}

TEST(NeighborSearch, senselessQueriesFindNothing) {
    World<3> world;
    world.fill(100, 10);
    const auto count = [&](const NeighborQuery& query) {
        return findNeighbors<3>(world.field, {*world.map, world.changes, world.occupied}, query)
            .size();
    };
    NeighborQuery query;
    EXPECT_GT(count(query), 50u);
    query.squaredRadius = -1;
    EXPECT_EQ(count(query), 0u);
    query.squaredRadius = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(count(query), 0u);
    query = {};
    query.most = 0;
    EXPECT_EQ(count(query), 0u);
    query = {};
    query.point.y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(count(query), 0u);
    query.point.y() = std::numeric_limits<double>::infinity();
    EXPECT_EQ(count(query), 0u);
    // Far outside of what cells can be addressed there are still nearest ones.
    query.point = {1e6, 0, 0};
    query.most = 3;
    EXPECT_EQ(count(query), 3u);
}

template <class Map>
Map mapOfScan() {
    Map map(0.1);
    mrpt::obs::CObservationPointCloud scan;
    auto points = mrpt::maps::CSimplePointsMap::Create();
    std::mt19937 random(5);
    std::uniform_real_distribution<float> angle(-3, 3), height(-0.5f, 0.5f);
    for (int i = 0; i < 800; ++i) {
        const float a = angle(random);
        points->insertPoint(3 * std::cos(a), 4 * std::sin(a), height(random));
    }
    scan.pointcloud = points;
    map.insertObservation(scan, mrpt::poses::CPose3D(0.3, 0.2, 0, 0.4, 0, 0));
    return map;
}

/// The maps' own functions, those of MRPT's interface where it has one.
template <class Map, int Dim>
void checkInterface() {
    const Map map = mapOfScan<Map>();
    // Where the interface exists, it is found by those who know the map as a CMetricMap.
    const mrpt::maps::CMetricMap& plain = map;
    const auto* const asInterface = dynamic_cast<const NearestNeighborsBase*>(&plain);
    ASSERT_NE(asInterface, nullptr);
#if SUPERRAY_HAS_MRPT_NEAREST_NEIGHBORS
    const mrpt::maps::NearestNeighborsCapable& nn = *asInterface;
#else
    const NearestNeighbors& nn = map;
#endif
    EXPECT_FALSE(nn.nn_has_indices_or_ids());
    nn.nn_prepare_for_2d_queries();
    nn.nn_prepare_for_3d_queries();
    const auto brute = [&](NeighborQuery query) {
        return bruteForce<Dim>(map.storage(), map.sensorModel().occupied(), query);
    };
    const auto check = [](const auto& points, const auto& squared, const auto& ids,
                          const std::vector<Neighbor>& expected) {
        ASSERT_EQ(points.size(), expected.size());
        ASSERT_EQ(squared.size(), expected.size());
        ASSERT_EQ(ids.size(), expected.size());
        for (std::size_t i = 0; i < expected.size(); ++i) {
            EXPECT_EQ(points[i].x, expected[i].point.x);
            EXPECT_EQ(points[i].y, expected[i].point.y);
            EXPECT_EQ(squared[i], static_cast<float>(expected[i].squaredDistance));
            EXPECT_EQ(ids[i], expected[i].id);
        }
    };
    std::mt19937 random(7);
    std::uniform_real_distribution<float> at(-5, 5);
    std::vector<mrpt::math::TPoint3Df> points3(7);  // what is in them is replaced
    std::vector<mrpt::math::TPoint2Df> points2(7);
    std::vector<float> squared(3);
    std::vector<std::uint64_t> ids(9);
    for (int i = 0; i < 60; ++i) {
        const mrpt::math::TPoint3Df p(at(random), at(random), at(random) / 5);
        const mrpt::math::TPoint2Df q(p.x, p.y);
        NeighborQuery in3, in2;
        in3.point = {p.x, p.y, p.z};
        in2.point = {p.x, p.y, 0};
        in2.distance = NeighborDistance::fromAbove;
        in3.most = in2.most = 1;
        points3.resize(1), points2.resize(1), squared.resize(1), ids.resize(1);
        ASSERT_TRUE(nn.nn_single_search(p, points3[0], squared[0], ids[0]));
        check(points3, squared, ids, brute(in3));
        ASSERT_TRUE(nn.nn_single_search(q, points2[0], squared[0], ids[0]));
        check(points2, squared, ids, brute(in2));
        in3.most = in2.most = 12;
        nn.nn_multiple_search(p, 12, points3, squared, ids);
        check(points3, squared, ids, brute(in3));
        EXPECT_EQ(points3.size(), 12u);
        nn.nn_multiple_search(q, 12, points2, squared, ids);
        check(points2, squared, ids, brute(in2));
        in3.squaredRadius = in2.squaredRadius = double{0.7f};
        in3.most = in2.most = 5;
        nn.nn_radius_search(p, 0.7f, points3, squared, ids, 5);
        check(points3, squared, ids, brute(in3));
        nn.nn_radius_search(q, 0.7f, points2, squared, ids, 5);
        check(points2, squared, ids, brute(in2));
        in3.most = in2.most = NeighborQuery{}.most;
        nn.nn_radius_search(p, 0.7f, points3, squared, ids, 0);
        check(points3, squared, ids, brute(in3));
        nn.nn_radius_search(q, 0.7f, points2, squared, ids, 0);
        check(points2, squared, ids, brute(in2));
    }
    const Map empty(0.1);
    EXPECT_FALSE(
        empty.nn_single_search(mrpt::math::TPoint3Df(0, 0, 0), points3[0], squared[0], ids[0]));
    empty.nn_multiple_search(mrpt::math::TPoint3Df(0, 0, 0), 3, points3, squared, ids);
    EXPECT_TRUE(points3.empty() && squared.empty() && ids.empty());
}

TEST(NeighborSearch, interfaceOfGrid3D) {
    checkInterface<CSuperRayGridMap3D, 3>();
}
TEST(NeighborSearch, interfaceOfOctree) {
    checkInterface<CSuperRayOctoMap, 3>();
}
TEST(NeighborSearch, interfaceOfGrid2D) {
    checkInterface<CSuperRayGridMap2D, 2>();
}

/// To be run under TSan, too.
TEST(NeighborSearch, severalThreadsFindTheSame) {
    const auto map = mapOfScan<CSuperRayGridMap3D>();
    const auto search = [&](unsigned seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> at(-5, 5);
        std::vector<Neighbor> all;
        for (unsigned i = 0; i < 200; ++i) {
            NeighborQuery query;
            query.point = {at(random), at(random), at(random) / 5};
            query.most = 1 + i % 4;
            if (i % 5 == 0) query.distance = NeighborDistance::fromAbove;
            const auto found = map.neighbors(query);
            all.insert(all.end(), found.begin(), found.end());
        }
        return all;
    };
    std::vector<std::vector<Neighbor>> found(4);
    std::vector<std::thread> threads;
    for (unsigned t = 0; t < 4; ++t) threads.emplace_back([&, t] { found[t] = search(t % 2); });
    for (auto& thread : threads) thread.join();
    for (unsigned t = 0; t < 4; ++t) {
        SCOPED_TRACE(t);
        EXPECT_GT(found[t].size(), 400u);
        expectSame(found[t], search(t % 2));
    }
}

}  // namespace
}  // namespace superray
