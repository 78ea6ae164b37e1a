// SPDX-License-Identifier: BSD-3-Clause
// Rays of 3D sensors in 2D maps, and rays that the maximum range cuts.

#include <gtest/gtest.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayQuadMap.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <vector>

#include "eval/sources/map_of_recording.h"
#include "eval/sources/room_scans.h"

namespace superray {
namespace {

using namespace test;
using mrpt::poses::CPose3D;

constexpr double kBandLow = 0.1, kBandHigh = 1.5;

/// Rays of a lidar at `sensorHeight` to points in the map; the robot is at the origin.
mrpt::obs::CObservationPointCloud::Ptr lidarScan(double seconds, double sensorHeight,
                                                 const std::vector<Eigen::Vector3f>& points) {
    auto scan = mrpt::obs::CObservationPointCloud::Create();
    scan->timestamp = at(seconds);
    scan->sensorLabel = "LIDAR";
    scan->sensorPose = CPose3D(0, 0, sensorHeight, 0, 0, 0);
    auto cloud = mrpt::maps::CSimplePointsMap::Create();
    for (const auto& p : points)
        cloud->insertPoint(p.x(), p.y(), p.z() - static_cast<float>(sensorHeight));
    scan->pointcloud = cloud;
    return scan;
}

/// A 2D map with the band, under each policy and by the reference too.
void inEveryWay(const std::function<void(CSuperRayGridMap2D&)>& check) {
    for (const auto policy :
         {UpdatePolicy::everyRay, UpdatePolicy::oncePerScan, UpdatePolicy::netEvidence})
        for (const auto method : {Method::automatic, Method::reference, Method::full}) {
            CSuperRayGridMap2D map(0.1);
            map.insertionOptions.policy = policy;
            map.insertionOptions.method = method;
            map.insertionOptions.heightBandMin = kBandLow;
            map.insertionOptions.heightBandMax = kBandHigh;
            check(map);
        }
}

void insertAll(CSuperRayGridMap2D& map,
               const std::vector<mrpt::obs::CObservationPointCloud::Ptr>& scans) {
    for (const auto& scan : scans) map.insertObservation(*scan, CPose3D());
}

TEST(RaysOf3DSensorsIn2DMaps, doNotClearWhatTheyPassOver) {
    // A kerb 0.2 m high at x = 3, and a wall at x = 6 that is seen over it.
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 40; ++i)
        points.emplace_back(6.05f, 0.05f, 0.75f + 0.01f * static_cast<float>(i));
    points.emplace_back(3.05f, 0.05f, 0.15f);
    inEveryWay([&](CSuperRayGridMap2D& map) {
        for (int i = 0; i < 20; ++i) insertAll(map, {lidarScan(i, 1.0, points)});
        EXPECT_EQ(occupied(map, 3.05, 0.05), true);
        EXPECT_EQ(occupied(map, 6.05, 0.05), true);
        EXPECT_EQ(occupied(map, 2.05, 0.05), false);
        EXPECT_EQ(occupied(map, 4.55, 0.05), false);
    });
}

TEST(RaysOf3DSensorsIn2DMaps, clearWhatTheyCrossInsideTheBandWhereverTheyEnd) {
    // A car at x = 4 drives off; then rays reach the floor behind its place (z = 0), and
    // the tree tops above it (z = 4).
    const std::vector<Eigen::Vector3f> car = {{4.05f, 0.05f, 0.5f}, {4.05f, 0.05f, 0.9f}};
    std::vector<Eigen::Vector3f> gone;
    for (int i = 0; i < 10; ++i)
        gone.emplace_back(4.6f + 0.1f * static_cast<float>(i), 0.05f, 0.0f);
    const std::vector<Eigen::Vector3f> tree = {{12.05f, 0.05f, 4.0f}};
    inEveryWay([&](CSuperRayGridMap2D& map) {
        insertAll(map, {lidarScan(0, 1.0, car)});
        EXPECT_EQ(occupied(map, 4.05, 0.05), true);
        for (int i = 1; i < 40; ++i) insertAll(map, {lidarScan(i, 1.0, gone)});
        EXPECT_EQ(occupied(map, 4.05, 0.05), false);
        EXPECT_EQ(map.lastInsertion().outOfHeightBand, 10u);
        // The ray to the tree top leaves the band 2 m ahead.
        map.clear();
        insertAll(map, {lidarScan(0, 1.0, tree)});
        EXPECT_EQ(occupied(map, 1.85, 0.05), false);
        EXPECT_FALSE(occupied(map, 2.15, 0.05));
        EXPECT_FALSE(occupied(map, 12.05, 0.05));
    });
}

TEST(RaysOf3DSensorsIn2DMaps, beginWhereTheyEnterTheBand) {
    // A sensor 2 m above the floor sees a point at 1 m height, 4 m ahead: the ray is above
    // the band for the first 2 m.
    const std::vector<Eigen::Vector3f> points = {{4.05f, 0.05f, 1.0f}};
    inEveryWay([&](CSuperRayGridMap2D& map) {
        insertAll(map, {lidarScan(0, 2.0, points)});
        EXPECT_FALSE(occupied(map, 1.85, 0.05));
        EXPECT_EQ(occupied(map, 2.25, 0.05), false);
        EXPECT_EQ(occupied(map, 4.05, 0.05), true);
        // Nothing of a ray that stays above is taken.
        map.clear();
        insertAll(map, {lidarScan(0, 2.0, {{9, 0, 1.9f}})});
        EXPECT_TRUE(map.isEmpty());
        EXPECT_EQ(map.lastInsertion().outOfHeightBand, 1u);
        // A sensor on the floor sees a point at 0.2 m height, 4 m ahead: the ray is below
        // the band, which begins at 0.1 m, for the first 2 m.
        map.clear();
        insertAll(map, {lidarScan(0, 0.0, {{4.05f, 0.05f, 0.2f}})});
        EXPECT_FALSE(occupied(map, 1.85, 0.05));
        EXPECT_EQ(occupied(map, 2.25, 0.05), false);
        EXPECT_EQ(occupied(map, 4.05, 0.05), true);
    });
}

TEST(RaysOf3DSensorsIn2DMaps, keepTheRangeLimitsOfTheSensor) {
    const std::vector<Eigen::Vector3f> points = {{9.05f, 0.05f, 1.0f}, {1.0f, 0.05f, 1.0f}};
    inEveryWay([&](CSuperRayGridMap2D& map) {
        map.insertionOptions.maxrange = 5;
        map.insertionOptions.minrange = 2;
        insertAll(map, {lidarScan(0, 1.0, points)});
        EXPECT_EQ(occupied(map, 4.85, 0.05), false);
        EXPECT_FALSE(occupied(map, 5.15, 0.05));
        EXPECT_EQ(map.lastInsertion().skipped.tooNear, 1u);
        EXPECT_EQ(map.lastInsertion().rays, 1u);
    });
}

TEST(RaysOf3DSensorsIn2DMaps, giveOneMapByEveryMethodAndStorage) {
    std::vector<mrpt::obs::CObservationPointCloud::Ptr> scans;
    for (unsigned i = 0; i < 4; ++i) scans.push_back(makeCloud(i, i, "LIDAR", 3000));
    for (const double low : {-std::numeric_limits<double>::infinity(), 0.1})
        for (const auto policy :
             {UpdatePolicy::everyRay, UpdatePolicy::oncePerScan, UpdatePolicy::netEvidence}) {
            std::string expected;
            const auto build = [&](auto map, Method method, unsigned threads) {
                map.insertionOptions.policy = policy;
                map.insertionOptions.method = method;
                map.insertionOptions.threads = threads;
                map.insertionOptions.heightBandMin = low;
                for (int round = 0; round < 3; ++round)
                    for (const auto& scan : scans)
                        EXPECT_TRUE(
                            map.insertObservation(*scan, CPose3D(0.3, 0, 0.2, 1, 0, 0)));
                if (expected.empty()) expected = map.digest();
                EXPECT_EQ(map.digest(), expected) << toString(method) << " " << threads;
            };
            for (const auto method : {Method::reference, Method::perRay, Method::superRays,
                                      Method::culling, Method::full, Method::automatic})
                for (const unsigned threads : {1u, 2u}) {
                    build(CSuperRayGridMap2D(0.1), method, threads);
                    build(CSuperRayQuadMap(0.1), method, threads);
                }
        }
}

TEST(MaximumRange, canClearTheCellWhereItCuts) {
    // In x the cut at 5.04 m lies in the cell from 5.0 to 5.1 m; the wall is at 8 m.
    const std::vector<Eigen::Vector3f> far = {{8.05f, 0.05f, 1.05f}};
    for (const bool clears : {false, true}) {
        CSuperRayGridMap3D space(0.1);
        CSuperRayGridMap2D plan(0.1);
        for (TInsertionOptions* o : {&space.insertionOptions, &plan.insertionOptions}) {
            o->maxrange = 5.04;
            o->clearAtMaxrange = clears;
        }
        const auto expectCleared = [&](mrpt::maps::CMetricMap& map) {
            const auto& cells = dynamic_cast<const SuperRayMapInterface&>(map);
            map.insertObservation(*lidarScan(0, 1.05, far), CPose3D(0.001, 0.05, 0, 0, 0, 0));
            EXPECT_EQ(occupied(cells, 4.95, 0.05, 1.05), false);
            EXPECT_EQ(occupied(cells, 5.05, 0.05, 1.05),
                      clears ? std::optional<bool>(false) : std::nullopt);
            EXPECT_FALSE(occupied(cells, 5.15, 0.05, 1.05));
        };
        expectCleared(space);
        expectCleared(plan);
        // A return in the cell of the cut is no reason to clear it.
        {
            CSuperRayGridMap3D other(0.1);
            other.insertionOptions.maxrange = 5.04;
            other.insertionOptions.clearAtMaxrange = clears;
            other.insertObservation(*lidarScan(0, 1.05, {{5.08f, 0.0f, 1.05f}}),
                                    CPose3D(0, 0.05, 0, 0, 0, 0));
            EXPECT_FALSE(occupied(other, 5.05, 0.05, 1.05));
        }
    }
}

TEST(RecordingCases, aLowObjectStaysInThePlan) {
    if (!std::filesystem::exists(casePath("low_object.rawlog")))
        GTEST_SKIP() << "CASES ABSENT: " << casePath("") << "; NOT TESTED";
    // The cells of the box, as the 3D map has them, seen from above.
    CSuperRayGridMap3D space(0.1);
    space.insertionOptions.policy = UpdatePolicy::oncePerScan;
    buildInto(space, casePath("low_object.rawlog"));
    std::set<std::pair<int, int>> box;
    for (int x = 138; x <= 143; ++x)
        for (int y = -15; y < 15; ++y)
            for (int z = 1; z < 5; ++z)
                if (space.isOccupied({(x + 0.5) * 0.1, (y + 0.5) * 0.1, (z + 0.5) * 0.1}))
                    box.emplace(x, y);
    EXPECT_EQ(box.size(), 12u);
    inEveryWay([&](CSuperRayGridMap2D& map) {
        buildInto(map, casePath("low_object.rawlog"));
        for (const auto& [x, y] : box)
            EXPECT_EQ(occupied(map, (x + 0.5) * 0.1, (y + 0.5) * 0.1), true) << x << " " << y;
    });
}

}  // namespace
}  // namespace superray
