// SPDX-License-Identifier: BSD-3-Clause
// Point statistics of the cells, and pairs that are as fine as the points.

#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPose2D.h>
#include <mrpt/tfest/TMatchingPair.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/surface_statistics.h>

#include <algorithm>
#include <map>
#include <random>

namespace superray {
namespace {

using mrpt::maps::CSimplePointsMap;
using mrpt::poses::CPose3D;

struct Matches {
    mrpt::tfest::TMatchingPairList pairs;
    mrpt::maps::TMatchingExtraResults extra;
};

Matches match(const mrpt::maps::CMetricMap& map, const CSimplePointsMap& points,
              const CPose3D& pose, const mrpt::maps::TMatchingParams& params) {
    Matches m;
    map.determineMatching3D(&points, pose, m.pairs, params, m.extra);
    return m;
}

/// Points of the plane z = 0.2 x + 0.1 y + 1.033, 4 m x 4 m.
std::vector<Point<3>> slopedWall(std::size_t count) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> in(-2, 2);
    std::vector<Point<3>> points;
    for (std::size_t i = 0; i < count; ++i) {
        const double x = in(random), y = in(random);
        points.emplace_back(x, y, 0.2 * x + 0.1 * y + 1.033);
    }
    return points;
}
const Eigen::Vector3d kWallNormal = Eigen::Vector3d(-0.2, -0.1, 1).normalized();
double distanceToWall(const Eigen::Vector3d& p) {
    return kWallNormal.dot(p - Eigen::Vector3d(0, 0, 1.033));
}

template <class Map, int Dim>
void insert(Map& map, const Point<Dim>& origin, const std::vector<Point<Dim>>& ends) {
    RayBundle<Dim> rays(map.storage().geometry(), origin);
    for (const auto& p : ends) rays.add(p);
    map.insertRays(rays);
}

TEST(SurfaceStatistics, AreThoseOfThePointsInTheCells) {
    const CellGeometry<3> geometry(0.5);
    const auto points = slopedWall(3000);
    SurfaceStatistics<3> statistics(geometry);
    // In three scans: the order and the grouping do not matter.
    for (std::size_t part = 0; part < 3; ++part) {
        RayBundle<3> rays(geometry, Point<3>(0.1, 0.2, 5));
        for (std::size_t i = part; i < points.size(); i += 3) rays.add(points[i]);
        rays.add(Point<3>(0.1, 0.2, 4), RayEnd::noReturn);
        statistics.add(rays);
    }
    std::map<Cell<3>, std::vector<Point<3>>> byCell;
    for (const auto& p : points) byCell[geometry.cellOf(p)].push_back(p);
    ASSERT_GT(byCell.size(), 60u);
    EXPECT_EQ(statistics.size(), byCell.size());
    for (const auto& [cell, inside] : byCell) {
        const auto* patch = statistics.patch(cell);
        ASSERT_NE(patch, nullptr);
        EXPECT_EQ(patch->points, inside.size());
        Point<3> mean = Point<3>::Zero();
        for (const auto& p : inside) mean += p / static_cast<double>(inside.size());
        EXPECT_LT((patch->mean - mean).norm(), 1e-9);
        EXPECT_GT(std::abs(patch->normal.dot(kWallNormal)), 1 - 1e-9);
        EXPECT_GT(patch->planarity, 0.99);
        const Point<3> off = patch->mean + Point<3>(0.1, -0.05, 0.2);
        EXPECT_NEAR(distanceToWall(patch->footPoint(off)), 0, 1e-9);
    }
    EXPECT_EQ(statistics.patch({0, 0, 8}), nullptr) << "where an open ray ended";
    EXPECT_EQ(statistics.patch({40000, 0, 0}), nullptr) << "not addressable";
}

TEST(SurfaceStatistics, FewPointsOrALineMakeNoPlane) {
    const CellGeometry<3> geometry(1);
    SurfaceStatistics<3> statistics(geometry);
    RayBundle<3> rays(geometry, Point<3>(0, 0, 0));
    for (int i = 0; i < 5; ++i) rays.add(Point<3>(10.1 + 0.1 * i * i, 10.5, 10.1 + 0.13 * i));
    for (int i = 0; i < 9; ++i) rays.add(Point<3>(20.1 + 0.09 * i, 20.5, 20.5));
    statistics.add(rays);
    for (const Cell<3>& cell : {Cell<3>{10, 10, 10}, Cell<3>{20, 20, 20}}) {
        const auto* patch = statistics.patch(cell);
        ASSERT_NE(patch, nullptr);
        EXPECT_EQ(patch->planarity, 0);
        EXPECT_EQ(patch->footPoint(Point<3>(1, 2, 3)), patch->mean);
    }
}

TEST(Matching, WithStatisticsPairsLieOnTheSurface) {
    const auto wall = slopedWall(20000);
    CSuperRayGridMap3D fine(0.2), coarse(0.2);
    fine.insertionOptions.pointStatistics = true;
    insert(fine, Point<3>(0.1, 0.1, 5), wall);
    insert(coarse, Point<3>(0.1, 0.1, 5), wall);
    EXPECT_EQ(fine.digest(), coarse.digest()) << "the cells are the same";
    EXPECT_EQ(coarse.pointStatistics(), nullptr);
    EXPECT_GT(fine.memoryBytes(), coarse.memoryBytes());

    CSimplePointsMap points;
    for (std::size_t i = 0; i < wall.size(); i += 100) {
        const Eigen::Vector3f p = wall[i].cast<float>();
        points.insertPoint(p.x(), p.y(), p.z());
    }
    mrpt::maps::TMatchingParams params;
    params.maxDistForCorrespondence = 0.2f;
    const CPose3D shifted(0, 0, 0.05, 0, 0, 0);
    const auto onSurface = match(fine, points, shifted, params);
    const auto onCentres = match(coarse, points, shifted, params);
    ASSERT_EQ(onSurface.pairs.size(), points.size());
    ASSERT_EQ(onCentres.pairs.size(), points.size());
    double worst = 0, worstCentre = 0;
    for (const auto& pair : onSurface.pairs)
        worst = std::max(
            worst, std::abs(distanceToWall({pair.global.x, pair.global.y, pair.global.z})));
    for (const auto& pair : onCentres.pairs)
        worstCentre =
            std::max(worstCentre,
                     std::abs(distanceToWall({pair.global.x, pair.global.y, pair.global.z})));
    EXPECT_LT(worst, 1e-4);
    EXPECT_GT(worstCentre, 0.02) << "else this shows nothing";
    // All points are 0.05 m above a plane that leans a little.
    const double apart = 0.05 * kWallNormal.z();
    EXPECT_NEAR(onSurface.extra.sumSqrDist, apart * apart, 1e-5);
    EXPECT_EQ(onSurface.extra.correspondencesRatio, 1.0f);
}

/// Points 1 m apart: in each cell one point, so the nearest cell has the nearest.
class AgainstPointsMap : public ::testing::Test {
 protected:
    AgainstPointsMap() : map_(0.1) {
        map_.insertionOptions.pointStatistics = true;
        std::mt19937 random(8);
        std::uniform_real_distribution<double> jitter(-0.04, 0.04);
        std::vector<Point<3>> ends;
        for (int x = -5; x < 5; ++x)
            for (int y = -5; y < 5; ++y)
                ends.emplace_back(x + 0.05 + jitter(random), y + 0.05 + jitter(random),
                                  0.05 + jitter(random));
        insert(map_, Point<3>(0.55, 0.55, 6), ends);
        std::uniform_real_distribution<double> away(-0.45, 0.45);
        for (const auto& p : ends) {
            reference_.insertPoint(static_cast<float>(p.x()), static_cast<float>(p.y()),
                                   static_cast<float>(p.z()));
            for (int i = 0; i < 3; ++i)
                other_.insertPoint(static_cast<float>(p.x() + away(random)),
                                   static_cast<float>(p.y() + away(random)),
                                   static_cast<float>(p.z() + away(random)));
        }
    }

    void expectEqual(const mrpt::maps::TMatchingParams& params) {
        const CPose3D pose(0.02, -0.01, 0.03, 0.01, 0.004, -0.003);
        auto ours = match(map_, other_, pose, params);
        auto theirs = match(reference_, other_, pose, params);
        ASSERT_EQ(ours.pairs.size(), theirs.pairs.size());
        matched_ = ours.pairs.size();
        const auto byLocal = [](const auto& a, const auto& b) {
            return a.localIdx < b.localIdx;
        };
        std::sort(ours.pairs.begin(), ours.pairs.end(), byLocal);
        std::sort(theirs.pairs.begin(), theirs.pairs.end(), byLocal);
        for (std::size_t i = 0; i < ours.pairs.size(); ++i) {
            const auto &a = ours.pairs[i], &b = theirs.pairs[i];
            ASSERT_EQ(a.localIdx, b.localIdx);
            EXPECT_LT(a.global.distanceTo(b.global), 1e-5);
            EXPECT_LT(a.local.distanceTo(b.local), 1e-6);
            EXPECT_NEAR(a.errorSquareAfterTransformation, b.errorSquareAfterTransformation,
                        1e-4);
        }
        EXPECT_NEAR(ours.extra.correspondencesRatio, theirs.extra.correspondencesRatio, 1e-4);
        EXPECT_NEAR(ours.extra.sumSqrDist, theirs.extra.sumSqrDist, 1e-4);
    }

    CSuperRayGridMap3D map_;
    CSimplePointsMap reference_, other_;
    std::size_t matched_ = 0;
};

TEST_F(AgainstPointsMap, SamePairsForEveryParameter) {
    mrpt::maps::TMatchingParams params;
    params.maxDistForCorrespondence = 0.3f;
    expectEqual(params);
    const std::size_t all = matched_;
    EXPECT_GT(all, 30u);
    EXPECT_LT(all, 290u) << "some are too far";

    params.maxDistForCorrespondence = 0.1f;
    params.maxAngularDistForCorrespondence = 0.05f;
    params.angularDistPivotPoint = {0, 0, 0};
    expectEqual(params);
    EXPECT_GT(matched_, 10u);
    params.angularDistPivotPoint = {-5, -5, 0};
    expectEqual(params);

    params = {};
    params.maxDistForCorrespondence = 0.3f;
    params.decimation_other_map_points = 4;
    params.offset_other_map_points = 3;
    expectEqual(params);
    EXPECT_LT(matched_, all / 2);

    params = {};
    params.maxDistForCorrespondence = 0.3f;
    params.onlyUniqueRobust = true;
    expectEqual(params);
    EXPECT_LT(matched_, all);
}

TEST_F(AgainstPointsMap, ContradictingParametersAreErrors) {
    mrpt::maps::TMatchingParams params;
    params.decimation_other_map_points = 0;
    EXPECT_THROW(match(map_, other_, CPose3D(), params), std::invalid_argument);
    params.decimation_other_map_points = 2;
    params.offset_other_map_points = 2;
    EXPECT_THROW(match(map_, other_, CPose3D(), params), std::invalid_argument);
    params = {};
    params.onlyUniqueRobust = true;
    params.onlyKeepTheClosest = false;
    EXPECT_THROW(match(map_, other_, CPose3D(), params), std::invalid_argument);
    EXPECT_TRUE(match(map_, CSimplePointsMap(), CPose3D(), {}).pairs.empty());
}

TEST(Matching, WhatHasGoneIsNotMatched) {
    CSuperRayGridMap3D map(0.2);
    map.insertionOptions.pointStatistics = true;
    const auto wall = slopedWall(2000);
    insert(map, Point<3>(0.1, 0.1, 5), wall);
    CSimplePointsMap points;
    for (const auto& p : wall)
        points.insertPoint(static_cast<float>(p.x()), static_cast<float>(p.y()),
                           static_cast<float>(p.z()));
    mrpt::maps::TMatchingParams params;
    params.maxDistForCorrespondence = 0.1f;
    ASSERT_EQ(match(map, points, CPose3D(), params).pairs.size(), points.size());
    // Now the sensor sees through to what lies behind.
    std::vector<Point<3>> behind;
    for (const auto& p : wall) behind.push_back(p + 0.8 * (p - Point<3>(0.1, 0.1, 5)));
    for (int i = 0; i < 30; ++i) insert(map, Point<3>(0.1, 0.1, 5), behind);
    const auto left = match(map, points, CPose3D(), params);
    EXPECT_LT(left.pairs.size(), points.size() / 20);
    EXPECT_LT(left.extra.correspondencesRatio, 0.05f);
    EXPECT_EQ(map.compute3DMatchingRatio(&points, CPose3D(5, 0, 0, 0, 0, 0), {}), 0.0f);
}

TEST(Matching, CopiesAndClearedMapsHaveTheirOwnStatistics) {
    CSuperRayOctoMap map(0.2);
    map.insertionOptions.pointStatistics = true;
    insert(map, Point<3>(0.1, 0.1, 5), slopedWall(500));
    const CSuperRayOctoMap copy = map;
    ASSERT_NE(copy.pointStatistics(), nullptr);
    const std::size_t before = copy.pointStatistics()->size();
    insert(map, Point<3>(0.1, 0.1, 5), {Point<3>(9, 9, 9)});
    EXPECT_EQ(map.pointStatistics()->size(), before + 1);
    EXPECT_EQ(copy.pointStatistics()->size(), before);
    map.clear();
    EXPECT_EQ(map.pointStatistics(), nullptr);
    EXPECT_EQ(copy.pointStatistics()->size(), before);
}

TEST(Matching, InTwoDimensionsPairsLieOnTheLine) {
    CSuperRayGridMap2D map(0.2);
    map.insertionOptions.pointStatistics = true;
    std::vector<Point<2>> line;
    for (int i = 0; i < 2000; ++i) line.emplace_back(0.002 * i, 1.03 + 0.0006 * i);
    insert(map, Point<2>(1.5, -3), line);
    CSimplePointsMap points;
    for (int i = 100; i < 1900; i += 50)
        points.insertPoint(0.002f * static_cast<float>(i),
                           1.06f + 0.0006f * static_cast<float>(i), 0.7f);
    mrpt::tfest::TMatchingPairList pairs;
    mrpt::maps::TMatchingExtraResults extra;
    mrpt::maps::TMatchingParams params;
    params.maxDistForCorrespondence = 0.3f;
    map.determineMatching2D(&points, mrpt::poses::CPose2D(), pairs, params, extra);
    ASSERT_EQ(pairs.size(), points.size());
    for (const auto& pair : pairs) {
        EXPECT_NEAR(pair.global.y, 1.03 + 0.3 * pair.global.x, 1e-4);
        EXPECT_EQ(pair.global.z, 0.7f) << "heights do not count";
    }
}

}  // namespace
}  // namespace superray
