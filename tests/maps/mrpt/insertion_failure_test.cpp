// SPDX-License-Identifier: BSD-3-Clause
// Memory that runs out at any allocation of an insertion: the map stays consistent, and
// works on when there is memory again.

#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayPointsMap.h>
#include <superray/maps/CSuperRayQuadMap.h>

#include <map>
#include <new>

#include "failing_allocations.h"
#include "maps/occupancy_of.h"
#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

template <int Dim>
using Blocks = std::map<BlockKey<Dim>, std::map<int, float>>;

template <int Dim>
Blocks<Dim> blocksOf(const CSuperRayMapBase<Dim>& map) {
    Blocks<Dim> blocks;
    map.storage().forEachBlock([&](const BlockView<Dim>& block) {
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (block.known.test(i)) blocks[block.key][i] = block.values[i];
    });
    return blocks;
}

template <int Dim>
std::size_t voxelsDrawn(const mrpt::maps::CMetricMap& map) {
    mrpt_viz::CSetOfObjects objects;
    map.getVisualizationInto(objects);
    const auto voxels = objects.template getByClass<mrpt_viz::COctoMapVoxels>();
    return voxels->getVoxelCount(mrpt_viz::VOXEL_SET_OCCUPIED);
}

template <int Dim>
void expectDerivedAgrees(const CSuperRayMapBase<Dim>& map) {
    EXPECT_EQ(voxelsDrawn<Dim>(map), map.cellTotals().occupied);
}

template <int Dim>
void expectDerivedAgrees(const CSuperRayPointsMap<Dim>& map) {
    expectDerivedAgrees<Dim>(map.occupancy());
    if (map.size() == 0) return;  // made with the next scan
    EXPECT_EQ(map.size(), map.occupancy().cellTotals().occupied);
    for (std::size_t i = 0; i < map.size(); ++i) {
        Eigen::Vector3f p;
        map.getPoint(i, p.x(), p.y(), p.z());
        EXPECT_TRUE(map.occupancy().isOccupied(p.template cast<double>()));
    }
}

/// Inserts while only so many allocations succeed. \return whether that threw
bool failsAfter(int succeeding, mrpt::maps::CMetricMap& map,
                const mrpt::obs::CObservation& observation, const CPose3D& pose) {
    test::allocations.allowed = succeeding;
    bool threw = false;
    try {
        map.insertObservation(observation, pose);
    } catch (const std::exception&) {  // MRPT may wrap bad_alloc
        threw = true;
    }
    test::allocations.allowed = -1;
    return threw;
}

template <class Map>
class InsertionFailure : public ::testing::Test {};
using Maps = ::testing::Types<CSuperRayGridMap2D, CSuperRayQuadMap, CSuperRayGridMap3D,
                              CSuperRayOctoMap, CSuperRayPointsMap2D, CSuperRayPointsMap3D>;
TYPED_TEST_SUITE(InsertionFailure, Maps);

TYPED_TEST(InsertionFailure, LeavesEachBlockOldOrNewAndAllElseInAgreement) {
    const auto first = test::randomCloud(300, 1), second = test::randomCloud(300, 2);
    const CPose3D pose(0.3, 0, 0, 0.2, 0, 0), moved(1.5, 0.5, 0, 0.4, 0, 0);
    const auto filled = [&] {
        auto map = std::make_unique<TypeParam>(0.2);
        map->insertObservation(*first, pose);
        expectDerivedAgrees(*map);  // views and fields exist
        return map;
    };
    const auto undisturbed = filled();
    const auto before = blocksOf(test::occupancyOf(*undisturbed));
    test::allocations.asked = 0;
    undisturbed->insertObservation(*second, moved);
    const int needed = test::allocations.asked;
    ASSERT_GT(needed, 10);
    const auto after = blocksOf(test::occupancyOf(*undisturbed));
    ASSERT_NE(before, after);

    int failures = 0;
    for (int succeeding = 0; succeeding < needed; succeeding += succeeding < 100 ? 1 : 7) {
        SCOPED_TRACE("allocation " + std::to_string(succeeding));
        const auto map = filled();
        const bool threw = failsAfter(succeeding, *map, *second, moved);
        failures += threw;
        auto now = blocksOf(test::occupancyOf(*map));
        auto old = before;
        for (const auto& [key, cells] : after)
            ASSERT_TRUE(now[key] == cells || now[key] == old[key]);
        for (const auto& block : now) ASSERT_TRUE(after.count(block.first) != 0);
        EXPECT_EQ(test::occupancyOf(*map).totals().scans, threw ? 1u : 2u) << "scans counted";
        expectDerivedAgrees(*map);
        map->insertObservation(*first, pose);
        expectDerivedAgrees(*map);
        if constexpr (std::is_base_of_v<mrpt::maps::CPointsMap, TypeParam>) {
            EXPECT_EQ(map->size(), map->occupancy().cellTotals().occupied);
        }
    }
    EXPECT_GT(failures, 10);
}

// The same while a window slides: a block may also be gone.
TYPED_TEST(InsertionFailure, WithAWindowLeavesEachBlockOldNewOrForgotten) {
    const auto first = test::randomCloud(300, 1), second = test::randomCloud(300, 2);
    const CPose3D pose(0.3, 0, 0, 0.2, 0, 0), moved(6, 0.5, 0, 0.4, 0, 0);
    const auto filled = [&] {
        auto map = std::make_unique<TypeParam>(0.2);
        TMapOptions options = test::occupancyOf(*map).options();
        options.insertion.windowRadius = 2;
        map->setOptions(options);
        map->insertObservation(*first, pose);
        expectDerivedAgrees(*map);
        return map;
    };
    const auto undisturbed = filled();
    const auto before = blocksOf(test::occupancyOf(*undisturbed));
    TypeParam unlimited(*undisturbed);
    TMapOptions options = test::occupancyOf(unlimited).options();
    options.insertion.windowRadius = 0;
    unlimited.setOptions(options);
    unlimited.insertObservation(*second, moved);
    auto after = blocksOf(test::occupancyOf(unlimited));
    test::allocations.asked = 0;
    undisturbed->insertObservation(*second, moved);
    const int needed = test::allocations.asked;
    EXPECT_GT(test::occupancyOf(*undisturbed).lastInsertion().forgottenBlocks, 0u);

    int failures = 0, late = 0;
    for (int succeeding = 0; succeeding < needed; succeeding += 3) {
        SCOPED_TRACE("allocation " + std::to_string(succeeding));
        const auto map = filled();
        const bool threw = failsAfter(succeeding, *map, *second, moved);
        failures += threw;
        auto old = before;
        for (const auto& [key, cells] : blocksOf(test::occupancyOf(*map))) {
            ASSERT_TRUE(cells == after[key] || cells == old[key]);
            old.erase(key);
        }
        late += threw && !old.empty();
        expectDerivedAgrees(*map);
        map->insertObservation(*first, pose);
        expectDerivedAgrees(*map);
    }
    EXPECT_GT(failures, 10);
    EXPECT_GT(late, 0) << "no failure after blocks were forgotten";
}

// The way to undo: copies share their cells until one of them changes.
TYPED_TEST(InsertionFailure, OfACopyLeavesTheOriginalForARetry) {
    const auto first = test::randomCloud(300, 1), second = test::randomCloud(300, 2);
    TypeParam undisturbed(0.2), map(0.2);
    for (TypeParam* m : {&undisturbed, &map}) m->insertObservation(*first, {});
    undisturbed.insertObservation(*second, {});
    const std::string before = test::occupancyOf(map).digest();
    int failures = 0;
    for (int succeeding = 0; succeeding < 400; succeeding += 9) {
        TypeParam trial(map);
        failures += failsAfter(succeeding, trial, *second, {});
        ASSERT_EQ(test::occupancyOf(map).digest(), before);
    }
    EXPECT_GT(failures, 3);
    map.insertObservation(*second, {});
    EXPECT_EQ(test::occupancyOf(map).digest(), test::occupancyOf(undisturbed).digest());
}

}  // namespace
}  // namespace superray
