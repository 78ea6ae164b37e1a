// SPDX-License-Identifier: BSD-3-Clause
// The sliding window: by definition, by every method, storage and number of threads; and
// what is derived from the cells follows.

#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <superray/core/reference_mapper.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayPointsMap.h>
#include <superray/maps/CSuperRayQuadMap.h>

#include <cmath>
#include <map>
#include <set>

#include "maps/test_scans.h"

namespace superray {
namespace {

constexpr double kResolution = 0.25, kBlockMetres = 8 * kResolution;

template <int Dim>
using Cells = std::map<Cell<Dim>, float>;

/// By definition: whether the gap between two blocks is larger than the radius.
template <int Dim>
bool isOutside(const BlockKey<Dim>& block, const BlockKey<Dim>& sensor, double radius) {
    double squared = 0;
    for (std::size_t a = 0; a < Dim; ++a) {
        const int blocksBetween = std::max(0, std::abs(block[a] - sensor[a]) - 1);
        squared += std::pow(blocksBetween * kBlockMetres, 2);
    }
    return std::sqrt(squared) > radius;
}

/// The slow, obvious map with a window.
template <int Dim>
void insertIntoOracle(Cells<Dim>& cells, const RayBundle<Dim>& rays,
                      const TInsertionOptions& options) {
    const SensorModel model = options.sensorModel();
    for (const auto& [cell, n] : countCells(rays))
        if (n.misses > 0 || n.hits > 0)
            cells[cell] = model.updated(cells[cell], n.misses, n.hits, options.policy);
    const BlockKey<Dim> sensor = blockOf<Dim>(rays.geometry().cellOf(rays.commonOrigin()));
    for (auto it = cells.begin(); it != cells.end();)
        it = isOutside<Dim>(blockOf<Dim>(it->first), sensor, options.windowRadius)
                 ? cells.erase(it)
                 : std::next(it);
}

/// Blocks with a cell that a scan's window leaves out.
template <int Dim>
std::size_t blocksOutside(const Cells<Dim>& cells, const RayBundle<Dim>& rays, double radius) {
    const BlockKey<Dim> sensor = blockOf<Dim>(rays.geometry().cellOf(rays.commonOrigin()));
    std::set<BlockKey<Dim>> outside;
    for (const auto& entry : cells) {
        const BlockKey<Dim> key = blockOf<Dim>(entry.first);
        if (isOutside<Dim>(key, sensor, radius)) outside.insert(key);
    }
    return outside.size();
}

template <int Dim>
Cells<Dim> cellsOf(const CSuperRayMapBase<Dim>& map) {
    Cells<Dim> cells;
    map.storage().forEachBlock([&](const BlockView<Dim>& block) {
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (block.known.test(i)) cells[cellInBlock<Dim>(block.key, i)] = block.values[i];
    });
    return cells;
}

/// Scans of a sensor that goes along x, seeded.
template <int Dim>
std::vector<RayBundle<Dim>> drive(int scans, std::size_t points) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> angle(-M_PI, M_PI), range(1, 9);
    std::vector<RayBundle<Dim>> rays;
    for (int s = 0; s < scans; ++s) {
        Point<Dim> origin = Point<Dim>::Zero();
        origin[0] = 1.3 * s - 4;
        origin[1] = std::sin(0.5 * s);
        rays.emplace_back(CellGeometry<Dim>(kResolution), origin);
        for (std::size_t i = 0; i < points; ++i) {
            Point<Dim> direction;
            const double a = angle(random), b = angle(random) / 4;
            direction[0] = std::cos(a);
            direction[1] = std::sin(a);
            if constexpr (Dim == 3) direction[2] = std::sin(b);
            rays.back().add(origin + range(random) * direction);
        }
    }
    return rays;
}

template <class Map>
class SlidingWindow : public ::testing::Test {};
using Maps = ::testing::Types<CSuperRayGridMap2D, CSuperRayQuadMap, CSuperRayGridMap3D,
                              CSuperRayOctoMap>;
TYPED_TEST_SUITE(SlidingWindow, Maps);

template <class Map>
constexpr int kDim = std::is_base_of_v<CSuperRayMapBase<2>, Map> ? 2 : 3;

TYPED_TEST(SlidingWindow, IsTheOracleByEveryMethodAndNumberOfThreads) {
    constexpr int Dim = kDim<TypeParam>;
    const auto scans = drive<Dim>(25, 250);
    for (const UpdatePolicy policy : {UpdatePolicy::netEvidence, UpdatePolicy::everyRay}) {
        std::vector<std::unique_ptr<TypeParam>> maps;
        TInsertionOptions options;
        options.setPolicy(policy);
        options.windowRadius = 4.5;
        for (const Method method : {Method::reference, Method::perRay, Method::superRays,
                                    Method::culling, Method::full, Method::automatic})
            for (const unsigned threads : {1u, 3u}) {
                maps.push_back(std::make_unique<TypeParam>(kResolution));
                options.method = method;
                options.threads = threads;
                maps.back()->insertionOptions = options;
            }
        Cells<Dim> oracle;
        std::uint64_t forgotten = 0;
        for (std::size_t s = 0; s < scans.size(); ++s) {
            insertIntoOracle<Dim>(oracle, scans[s], options);
            for (const auto& map : maps) {
                map->insertRays(scans[s]);
                ASSERT_TRUE(cellsOf<Dim>(*map) == oracle)
                    << "scan " << s << ", " << toString(map->insertionOptions.method) << ", "
                    << map->insertionOptions.threads << " threads";
                forgotten += map->lastInsertion().forgottenBlocks;
            }
        }
        EXPECT_GT(oracle.size(), 500u);
        EXPECT_GT(forgotten, 1000u);
        EXPECT_EQ(maps[0]->totals().scans, scans.size());
    }
}

/// With an option changed on the way, and a map that was loaded.
TYPED_TEST(SlidingWindow, TakesEffectAtTheNextScan) {
    constexpr int Dim = kDim<TypeParam>;
    const auto scans = drive<Dim>(12, 200);
    TypeParam map(kResolution);
    Cells<Dim> oracle;
    for (std::size_t s = 0; s < scans.size(); ++s) {
        map.insertionOptions.windowRadius = s < 8 ? 1000 : 2;
        const std::size_t toForget =
            blocksOutside<Dim>(oracle, scans[s], map.insertionOptions.windowRadius);
        map.insertRays(scans[s]);
        insertIntoOracle<Dim>(oracle, scans[s], map.insertionOptions);
        EXPECT_TRUE(cellsOf<Dim>(map) == oracle);
        EXPECT_EQ(map.lastInsertion().forgottenBlocks, toForget) << s;
        // Later scans may find nothing to forget: what they see outside is not inserted.
        if (s <= 8) {
            EXPECT_EQ(toForget == 0, s < 8) << s;
        }
    }
    const test::TempFolder folder;
    map.saveToFile(folder.file("window.srmap"));
    TypeParam loaded(1.0);
    loaded.loadFromFile(folder.file("window.srmap"));
    EXPECT_EQ(loaded.insertionOptions.windowRadius, 2);
    loaded.insertRays(scans[0]);
    insertIntoOracle<Dim>(oracle, scans[0], map.insertionOptions);
    EXPECT_TRUE(cellsOf<Dim>(loaded) == oracle);
}

// Copies share cells, so a copy without window must not lose any.
TYPED_TEST(SlidingWindow, LeavesCopiesAlone) {
    constexpr int Dim = kDim<TypeParam>;
    const auto scans = drive<Dim>(2, 200);
    TypeParam map(kResolution);
    map.insertionOptions.pointStatistics = true;
    map.insertRays(scans[0]);
    const TypeParam copy(map);
    const std::string digest = copy.digest();
    const std::size_t patches = copy.pointStatistics()->size();
    map.insertionOptions.windowRadius = 1;
    map.insertionOptions.pointStatistics = false;
    map.insertRays(scans[1]);
    EXPECT_GT(map.lastInsertion().forgottenBlocks, 0u);
    EXPECT_EQ(copy.digest(), digest);
    EXPECT_EQ(copy.pointStatistics()->size(), patches);
    EXPECT_LT(map.pointStatistics()->size(), patches);
}

template <int Dim>
void expectStatisticsOfKnownCellsOnly(const CSuperRayMapBase<Dim>& map,
                                      const std::set<Cell<Dim>>& ends) {
    std::size_t patches = 0;
    for (const Cell<Dim>& cell : ends) {
        const auto* patch = map.pointStatistics()->patch(cell);
        if (!map.storage().logOdds(cell)) {
            EXPECT_EQ(patch, nullptr) << "statistics of a forgotten cell";
        }
        patches += patch != nullptr;
    }
    EXPECT_EQ(patches, map.pointStatistics()->size());
    EXPECT_GT(patches, 20u);
}

TYPED_TEST(SlidingWindow, DerivedDataFollow) {
    constexpr int Dim = kDim<TypeParam>;
    const auto scans = drive<Dim>(20, 150);
    TypeParam map(kResolution);
    map.insertionOptions.windowRadius = 3;
    map.insertionOptions.pointStatistics = true;
    std::set<Cell<Dim>> ends;
    std::size_t changedBlocks = 0;
    for (const RayBundle<Dim>& rays : scans) {
        const std::uint64_t before = map.changeStamp();
        const auto old = cellsOf<Dim>(map);
        map.insertRays(rays);
        for (std::size_t i = 0; i < rays.size(); ++i)
            ends.insert(rays.geometry().cellOf(rays.end(i)));
        const TypeParam fresh(map);  // the same cells, nothing derived yet

        std::set<BlockKey<Dim>> changed;
        ASSERT_TRUE(map.forEachChangedBlock(
            before, [&](const BlockKey<Dim>& key) { changed.insert(key); }));
        const auto now = cellsOf<Dim>(map);
        for (const auto& [cell, value] : old)
            if (now.count(cell) == 0) {
                EXPECT_EQ(changed.count(blockOf<Dim>(cell)), 1u);
                changedBlocks += changed.size();
            }

        mrpt_viz::CSetOfObjects objects;
        map.getVisualizationInto(objects);
        EXPECT_EQ(objects.template getByClass<mrpt_viz::COctoMapVoxels>()->getVoxelCount(
                      mrpt_viz::VOXEL_SET_OCCUPIED),
                  map.cellTotals().occupied);
        expectStatisticsOfKnownCellsOnly<Dim>(map, ends);
        for (int i = 0; i < 200; ++i) {
            const Eigen::Vector3d point(rays.commonOrigin()[0] + 0.1 * i - 10, 0.02 * i - 2,
                                        0.1);
            const auto got = map.nearestObstacle(point, 5),
                       want = fresh.nearestObstacle(point, 5);
            ASSERT_EQ(got.has_value(), want.has_value());
            if (got) {
                EXPECT_DOUBLE_EQ(got->distance, want->distance);
            }
            for (const unsigned level : {0u, 2u, 5u})
                EXPECT_EQ(map.logOddsAtLevel(point, level, LevelRule::maximum),
                          fresh.logOddsAtLevel(point, level, LevelRule::maximum));
        }
        EXPECT_EQ(map.getAsSimplePointsMap()->size(), map.cellTotals().occupied);
    }
    EXPECT_GT(changedBlocks, 100u);
}

template <class Map>
class PointsWindow : public ::testing::Test {};
using PointsMaps = ::testing::Types<CSuperRayPointsMap2D, CSuperRayPointsMap3D>;
TYPED_TEST_SUITE(PointsWindow, PointsMaps);

TYPED_TEST(PointsWindow, PointsAndLikelihoodFollow) {
    TypeParam map(0.2), without(0.2);
    TMapOptions options = map.occupancy().options();
    options.creation.resolution = 0.2;
    options.insertion.windowRadius = 2.5;
    map.setOptions(options);
    const auto probe = test::randomCloud(200, 99);
    for (unsigned s = 0; s < 30; ++s) {
        const auto scan = test::randomCloud(200, s);
        const mrpt::poses::CPose3D pose(0.8 * s, 0.2 * std::sin(s), 0, 0.3 * s, 0, 0);
        map.insertObservation(*scan, pose);
        without.insertObservation(*scan, pose);
        ASSERT_EQ(map.size(), map.occupancy().cellTotals().occupied);
        for (std::size_t i = 0; i < map.size(); ++i) {
            Eigen::Vector3f p;
            map.getPoint(i, p.x(), p.y(), p.z());
            ASSERT_TRUE(map.occupancy().isOccupied(p.template cast<double>()));
        }
        const TypeParam fresh(map);
        ASSERT_EQ(map.computeObservationLikelihood(*probe, pose),
                  fresh.computeObservationLikelihood(*probe, pose));
    }
    EXPECT_LT(map.size(), without.size() / 2);
    EXPECT_GT(map.size(), 20u);
}

// The window is around the sensor, also where rays begin elsewhere: at a band of heights below.
TEST(WindowOfABand, IsAroundTheSensorWhateverReturnIsFirst) {
    const auto insert = [](CSuperRayMapBase<2>& map, const std::vector<Eigen::Vector3f>& ends) {
        const auto scan = mrpt::obs::CObservationPointCloud::Create();
        const auto cloud = mrpt::maps::CSimplePointsMap::Create();
        for (const auto& p : ends) cloud->insertPoint(p.x(), p.y(), p.z());
        scan->pointcloud = cloud;
        ASSERT_TRUE(map.insertObservation(*scan, mrpt::poses::CPose3D(0, 0, 2, 0, 0, 0)));
    };
    const Eigen::Vector3f grazing(20, 0, -1.1f), near(-1, 0, -1.5f);
    std::set<std::string> digests;
    for (const auto& ends : {std::vector{grazing, near}, std::vector{near, grazing}}) {
        CSuperRayGridMap2D map(0.1);
        map.insertionOptions.windowRadius = 5;
        map.insertionOptions.heightBandMin = 0;
        map.insertionOptions.heightBandMax = 1;
        insert(map, {{1, 0, -1.5f}, {0, 1, -1.5f}});
        insert(map, ends);
        EXPECT_TRUE(map.occupancyAt({1, 0, 0})) << "of the first scan";
        EXPECT_TRUE(map.occupancyAt({-1, 0, 0}));
        EXPECT_FALSE(map.occupancyAt({20, 0, 0}));
        digests.insert(map.digest());
    }
    EXPECT_EQ(digests.size(), 1u);
}

// In short: superray-bench soak.
TEST(Soak, MemoryAfterThreeLapsIsThatAfterOne) {
    for (const auto& className : mapClassNames()) {
        const auto map = createMap(className);
        TMapOptions options = test::interfaceOf(*map).options();
        options.insertion.windowRadius = 6;
        test::interfaceOf(*map).setOptions(options);
        std::size_t afterOne = 0;
        for (unsigned s = 0; s < 180; ++s) {
            const mrpt::poses::CPose3D pose(1.0 * s, 0, 0, 0.1 * s, 0, 0);
            const auto scan = test::randomCloud(300, s % 20);
            map->insertObservation(*scan, pose);
            map->computeObservationLikelihood(*scan, pose);
            if (s == 59) afterOne = test::interfaceOf(*map).heldBytes();
        }
        EXPECT_LE(test::interfaceOf(*map).heldBytes(), afterOne * 11 / 10) << className;
        EXPECT_GT(test::interfaceOf(*map).totals().forgottenBlocks, 500u) << className;
    }
}

}  // namespace
}  // namespace superray
