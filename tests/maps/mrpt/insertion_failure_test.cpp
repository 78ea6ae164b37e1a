// SPDX-License-Identifier: BSD-3-Clause
// Memory that runs out at any allocation of an insertion: the map is as it was, and the scan
// can be inserted again.

#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayPointsMap.h>
#include <superray/maps/CSuperRayQuadMap.h>

#include <algorithm>
#include <array>
#include <memory>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include "failing_allocations.h"
#include "maps/occupancy_of.h"
#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

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

template <int Dim>
void describe(const CSuperRayMapBase<Dim>& map, std::ostream& text) {
    text << map.digest() << ' ' << map.totals().scans << ' ' << map.totals().rays;
    const SurfaceStatistics<Dim>* const statistics = map.pointStatistics();
    if (!statistics) return;
    map.storage().forEachBlock([&](const BlockView<Dim>& block) {
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (const auto* p = statistics->patch(cellInBlock<Dim>(block.key, i)))
                text << "\n" << p->points << ' ' << p->mean.transpose() << ' ' << p->planarity;
    });
}

/// All that a scan changes, as text.
template <class Map>
std::string stateOf(const Map& map) {
    std::ostringstream text;
    describe(test::occupancyOf(map), text);
    if constexpr (std::is_base_of_v<mrpt::maps::CPointsMap, Map>) {
        std::vector<std::array<float, 3>> points(map.size());
        for (std::size_t i = 0; i < map.size(); ++i)
            map.getPoint(i, points[i][0], points[i][1], points[i][2]);
        std::sort(points.begin(), points.end());
        for (const auto& p : points) text << "\n" << p[0] << ' ' << p[1] << ' ' << p[2];
    }
    return text.str();
}

/// What is inserted, and how.
enum class Kind { plain, counted, full, statistics, window, threads };
constexpr Kind kKinds[] = {Kind::plain,      Kind::counted, Kind::full,
                           Kind::statistics, Kind::window,  Kind::threads};
/// Points of the first scan. After a small one, buffers must grow in the second.
constexpr int kFirstPoints[] = {120, 1};

template <class Map>
void setKind(Map& map, Kind kind) {
    TMapOptions options = test::occupancyOf(map).options();
    switch (kind) {
        case Kind::plain:
            break;
        case Kind::counted:
            options.insertion.method = Method::reference;
            break;
        case Kind::full:
            options.insertion.method = Method::full;
            options.insertion.superRayThreshold = 1;
            break;
        case Kind::statistics:
            options.insertion.pointStatistics = true;
            break;
        case Kind::window:
            options.insertion.windowRadius = 2;
            options.insertion.pointStatistics = true;
            break;
        case Kind::threads:
            options.insertion.threads = 2;
            break;
    }
    map.setOptions(options);
}

/// A map that has a scan already, and another scan.
template <class Map>
struct Insertion {
    Kind kind;
    mrpt::obs::CObservation::Ptr first, second;
    CPose3D pose{0.3, 0, 0, 0.2, 0, 0}, moved;

    explicit Insertion(Kind k, int firstPoints = 120)
        : kind(k),
          first(test::randomCloud(firstPoints, 1)),
          second(test::randomCloud(120, 2)),
          // Out of the window, and into a part of it.
          moved(k == Kind::window ? 2.5 : 1.5, 0.5, 0, 0.4, 0, 0) {}

    std::unique_ptr<Map> filled() const {
        auto map = std::make_unique<Map>(0.2);
        setKind(*map, kind);
        map->insertObservation(*first, pose);
        expectDerivedAgrees(*map);  // views and fields exist
        return map;
    }
};

template <class Map>
class InsertionFailure : public ::testing::Test {};
using Maps = ::testing::Types<CSuperRayGridMap2D, CSuperRayQuadMap, CSuperRayGridMap3D,
                              CSuperRayOctoMap, CSuperRayPointsMap2D, CSuperRayPointsMap3D>;
TYPED_TEST_SUITE(InsertionFailure, Maps);

/// Fails at each allocation of the second scan, then inserts it again.
template <class Map>
void failEverywhere(const Insertion<Map>& insertion) {
    const auto undisturbed = insertion.filled();
    const std::string before = stateOf(*undisturbed);
    test::allocations.asked = 0;
    undisturbed->insertObservation(*insertion.second, insertion.moved);
    const int needed = test::allocations.asked;
    const std::string after = stateOf(*undisturbed);
    ASSERT_NE(before, after);

    int failures = 0;
    for (int allowed = 0; allowed < needed; ++allowed) {
        SCOPED_TRACE("allocation " + std::to_string(allowed));
        const auto map = insertion.filled();
        if (!failsAfter(allowed, *map, *insertion.second, insertion.moved)) {
            ASSERT_EQ(stateOf(*map), after) << "no error, so it must have been inserted";
            continue;
        }
        ++failures;
        if (insertion.kind != Kind::window) {
            ASSERT_EQ(stateOf(*map), before);
        }
        expectDerivedAgrees(*map);
        map->insertObservation(*insertion.second, insertion.moved);
        ASSERT_EQ(stateOf(*map), after);
        expectDerivedAgrees(*map);
    }
    EXPECT_GT(failures, 10);
}

TYPED_TEST(InsertionFailure, LeavesTheMapForARetry) {
    for (const Kind kind : kKinds)
        for (const int points : kFirstPoints) {
            SCOPED_TRACE("kind " + std::to_string(static_cast<int>(kind)) +
                         ", points before: " + std::to_string(points));
            failEverywhere(Insertion<TypeParam>(kind, points));
            if (this->HasFatalFailure()) return;
        }
}

// Copies share their cells until one of them changes, or fails to.
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

template <class Map>
class MergeFailure : public ::testing::Test {};
using OccupancyMaps = ::testing::Types<CSuperRayGridMap2D, CSuperRayQuadMap, CSuperRayGridMap3D,
                                       CSuperRayOctoMap>;
TYPED_TEST_SUITE(MergeFailure, OccupancyMaps);

// Log-odds are added, so a part that is merged twice is wrong.
TYPED_TEST(MergeFailure, LeavesTheMapForARetry) {
    TypeParam other(0.2);
    other.insertObservation(*test::randomCloud(120, 2), CPose3D(0.7, 0.2, 0, 0.4, 0, 0));
    const auto made = [] {
        auto map = std::make_unique<TypeParam>(0.2);
        map->insertObservation(*test::randomCloud(40, 1), CPose3D());
        expectDerivedAgrees(*map);
        return map;
    };
    const auto undisturbed = made();
    const std::string before = undisturbed->digest();
    test::allocations.asked = 0;
    undisturbed->merge(other, CPose3D());
    const int needed = test::allocations.asked;
    const std::string after = undisturbed->digest();
    ASSERT_NE(before, after);
    ASSERT_GT(needed, 10);

    int failures = 0;
    for (int allowed = 0; allowed < needed; ++allowed) {
        SCOPED_TRACE("allocation " + std::to_string(allowed));
        const auto map = made();
        test::allocations.allowed = allowed;
        bool threw = false;
        try {
            map->merge(other, CPose3D());
        } catch (const std::bad_alloc&) {
            threw = true;
        }
        test::allocations.allowed = -1;
        if (threw) {
            ++failures;
            ASSERT_EQ(map->digest(), before);
            expectDerivedAgrees(*map);
            map->merge(other, CPose3D());
        }
        ASSERT_EQ(map->digest(), after);
        expectDerivedAgrees(*map);
    }
    EXPECT_GT(failures, 10);
}

/// Cells of `before` that `now` does not know. The others must be as before, and `after` must
/// not know these either: they are outside the window.
template <int Dim>
int forgottenCells(const CSuperRayMapBase<Dim>& before, const CSuperRayMapBase<Dim>& now,
                   const CSuperRayMapBase<Dim>& after) {
    int gone = 0;
    before.storage().forEachBlock([&](const BlockView<Dim>& block) {
        for (int i = 0; i < kBlockCells<Dim>; ++i) {
            if (!block.known.test(i)) continue;
            const Cell<Dim> cell = cellInBlock<Dim>(block.key, i);
            const auto value = now.storage().logOdds(cell);
            gone += !value;
            EXPECT_TRUE(value ? *value == block.values[i] : !after.storage().logOdds(cell));
        }
    });
    EXPECT_EQ(now.cellTotals().known + gone, before.cellTotals().known);
    return gone;
}

TYPED_TEST(InsertionFailure, OnlyForgetsWhatIsOutsideAWindow) {
    const Insertion<TypeParam> insertion(Kind::window);
    const auto before = insertion.filled(), after = insertion.filled();
    test::allocations.asked = 0;
    after->insertObservation(*insertion.second, insertion.moved);
    const int needed = test::allocations.asked;
    EXPECT_GT(test::occupancyOf(*after).lastInsertion().forgottenBlocks, 0u);

    int early = 0, late = 0;
    for (int allowed = 0; allowed < needed; ++allowed) {
        const auto map = insertion.filled();
        if (!failsAfter(allowed, *map, *insertion.second, insertion.moved)) continue;
        const int gone = forgottenCells(test::occupancyOf(*before), test::occupancyOf(*map),
                                        test::occupancyOf(*after));
        ++(gone == 0 ? early : late);
    }
    EXPECT_GT(early, 10);
    EXPECT_GT(late, 0) << "no failure after cells were forgotten";
}

}  // namespace
}  // namespace superray
