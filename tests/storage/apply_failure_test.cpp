// SPDX-License-Identifier: BSD-3-Clause
// When memory runs out in an update, the map is as it was.

#include "storage/tree/octree_test_tools.h"

#include <superray/storage/block_grid.h>

#include <new>
#include <string>
#include <type_traits>

#include "core/counts_of.h"
#include "failing_allocations.h"

namespace superray::test {
namespace {

/// A batch on a map that has something already.
struct Update {
    UpdateBatch<3> first, second;
    Update() {
        std::mt19937 random(77);
        for (int i = 0; i < 200; ++i)
            addRandomBlock<3>(first, {i % 20 - 10, i / 20, i % 3}, static_cast<Fill>(i % 6),
                              random);
        for (int i = 0; i < 1100; ++i)
            addRandomBlock<3>(second, {i % 30 - 10, i / 30 - 20, i % 3},
                              static_cast<Fill>(1 + i % 5), random);
    }
};

template <typename Map>
Map firstApplied(const Update& update) {
    Map map{CellGeometry<3>(0.1)};
    map.apply(update.first, SensorModel(), UpdatePolicy::everyRay);
    return map;
}

/// Lets more and more allocations succeed in `apply`, until it succeeds. All that fail must
/// leave the map as it was, and able to do it afterwards.
/// \return how many failed
template <typename Map, typename Apply>
int failAtEachAllocation(const Update& update, const Apply& apply) {
    const Map undisturbed = firstApplied<Map>(update);
    const std::string before = contentDigest<3>(undisturbed);
    Map retried = firstApplied<Map>(update);
    apply(retried);
    const std::string after = contentDigest<3>(retried);
    const float lowest = SensorModel().min();
    const Cells<3> old = cellsOf<3>(undisturbed);
    Cells<3> expected = old;
    applyToOracle(expected, update.second, SensorModel(), UpdatePolicy::everyRay);
    EXPECT_TRUE(equalsOracle<3>(retried, expected));

    const auto expectedTree = octomapTree(expected, 0.1);

    int failed = 0;
    for (bool succeeded = false; !succeeded; failed += !succeeded) {
        Map map = firstApplied<Map>(update);
        allocations.allowed = failed;
        try {
            apply(map);
            succeeded = true;
        } catch (const std::bad_alloc&) {
        }
        allocations.allowed = -1;
        if (!succeeded) {
            EXPECT_EQ(contentDigest<3>(map), before) << "after " << failed << " allocations";
            EXPECT_TRUE(saturationEquals<3>(map, old, lowest));
            apply(map);
        }
        EXPECT_EQ(contentDigest<3>(map), after) << "after " << failed << " allocations";
        EXPECT_TRUE(saturationEquals<3>(map, expected, lowest));
        if constexpr (std::is_same_v<Map, Octree>) {
            EXPECT_TRUE(sameNodes(map.tree(), *expectedTree));
        }
        if (::testing::Test::HasFailure()) break;
    }
    return failed;
}

template <typename Map>
void applyCounts(Map& map, const CellCountMap<3>& counts) {
    map.OccupancyMap<3>::apply(counts, SensorModel(), UpdatePolicy::everyRay);
}

template <class Map>
class ApplyFailure : public ::testing::Test {};
using Maps = ::testing::Types<Octree, BlockGrid<3>>;
TYPED_TEST_SUITE(ApplyFailure, Maps);

TYPED_TEST(ApplyFailure, LeavesTheMapAsItWas) {
    const Update update;
    for (const unsigned threads : {1u, 2u}) {
        const int failed = failAtEachAllocation<TypeParam>(update, [&](TypeParam& map) {
            map.apply(update.second, SensorModel(), UpdatePolicy::everyRay, threads);
        });
        EXPECT_GT(failed, 5) << threads << " threads";
    }
}

TYPED_TEST(ApplyFailure, OfExactCountsLeavesTheMapAsItWas) {
    std::mt19937 random(78);
    Update few;
    few.second = UpdateBatch<3>();
    for (int i = 0; i < 12; ++i)
        addRandomBlock<3>(few.second, {i - 6, i % 3, i % 2}, static_cast<Fill>(1 + i % 5),
                          random);
    const CellCountMap<3> counts = countsOf<3>(few.second);
    const int failed =
        failAtEachAllocation<TypeParam>(few, [&](TypeParam& map) { applyCounts(map, counts); });
    EXPECT_GT(failed, 5);
}

}  // namespace
}  // namespace superray::test
