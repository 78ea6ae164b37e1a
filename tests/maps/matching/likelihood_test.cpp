// SPDX-License-Identifier: BSD-3-Clause
// Likelihood and matching: the true pose is the best one.

#include <mrpt/maps/COctoMap.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/tfest/TMatchingPair.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayQuadMap.h>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

/// A room of 6 x 4 m seen by a laser (2D) at its middle.
mrpt::obs::CObservation2DRangeScan::Ptr roomScan() {
    auto scan = mrpt::obs::CObservation2DRangeScan::Create();
    scan->aperture = static_cast<float>(2 * M_PI * 359 / 360);
    scan->maxRange = 20;
    scan->sensorLabel = "LASER";
    scan->resizeScanAndAssign(360, 0, true);
    for (std::size_t i = 0; i < 360; ++i) {
        const double a = scan->getScanAngle(i);
        const double range =
            std::min(std::abs(2.97 / std::cos(a)), std::abs(1.97 / std::sin(a)));
        scan->setScanRange(i, static_cast<float>(range));
    }
    return scan;
}

template <class Map>
void expectTruePoseIsBest() {
    Map map(0.1);
    const auto scan = roomScan();
    const CPose3D truth(0.4, -0.3, 0.02, 0.3, 0, 0);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(map.insertObservation(*scan, truth));
    ASSERT_TRUE(map.canComputeObservationLikelihood(*scan));
    const double best = map.computeObservationLikelihood(*scan, truth);
    EXPECT_LE(best, 0);
    EXPECT_GE(best, -360 * 0.05) << "nearly all end points lie in occupied cells";
    std::size_t perturbed = 0;
    for (const double dx : {-0.3, -0.15, 0.0, 0.15, 0.3})
        for (const double dy : {-0.3, 0.0, 0.3})
            for (const double dyaw : {-0.2, 0.0, 0.2}) {
                if (dx == 0 && dy == 0 && dyaw == 0) continue;
                const auto pose = truth + CPose3D(dx, dy, 0, dyaw, 0, 0);
                EXPECT_LT(map.computeObservationLikelihood(*scan, pose), best - 1)
                    << dx << " " << dy << " " << dyaw;
                ++perturbed;
            }
    EXPECT_EQ(perturbed, 44u);
    // A pose beyond the addressable cells is no way out.
    EXPECT_LT(map.computeObservationLikelihood(*scan, CPose3D(3275, 0, 0, 0, 0, 0)),
              best - 100);
}

TEST(Likelihood, TheTruePoseIsBest) {
    expectTruePoseIsBest<CSuperRayGridMap2D>();
    expectTruePoseIsBest<CSuperRayQuadMap>();
    expectTruePoseIsBest<CSuperRayGridMap3D>();
    expectTruePoseIsBest<CSuperRayOctoMap>();
}

/// One return at a place of the map's choosing.
mrpt::obs::CObservationPointCloud pointAt(double x, double y, double z) {
    mrpt::obs::CObservationPointCloud scan;
    scan.pointcloud = mrpt::maps::CSimplePointsMap::Create();
    scan.pointcloud->insertPoint(static_cast<float>(x), static_cast<float>(y),
                                 static_cast<float>(z));
    return scan;
}

TEST(Likelihood, ScoresOfSinglePoints) {
    CSuperRayGridMap3D map(0.1);
    // Wall cell x in [2, 2.1); free before it; unknown behind.
    ASSERT_TRUE(map.insertObservation(pointAt(2.05, 0.05, 0.05)));
    map.likelihoodOptions.sigma = 0.2;
    map.likelihoodOptions.maxDistance = 0.4;
    map.likelihoodOptions.unknownLikelihood = 0.25;
    const auto score = [&](double x, double y) {
        return map.computeObservationLikelihood(pointAt(x, y, 0.05), CPose3D());
    };
    EXPECT_EQ(score(2.05, 0.05), 0);
    EXPECT_EQ(score(2.01, 0.09), 0);
    EXPECT_NEAR(score(1.9, 0.05), -0.5 * 0.25, 1e-5);      // 0.1 m away
    EXPECT_NEAR(score(2.25, 0.05), -0.5 * 0.5625, 1e-5);   // 0.15 m behind, unknown
    EXPECT_NEAR(score(2.2, 0.2), -0.5 * 0.5, 1e-5);        // diagonally
    EXPECT_NEAR(score(1.05, 0.05), -0.5 * 4, 1e-9);        // free and far
    EXPECT_NEAR(score(1.05, 3.05), std::log(0.25), 1e-9);  // unknown and far
    map.likelihoodOptions.unknownLikelihood = 1;
    EXPECT_LE(score(1.05, 3.05), score(2.05, 0.05)) << "unknown never above a hit";
    // Mixed with a uniform part, a hit still has 1 and nothing is worse than the part.
    map.likelihoodOptions.uniformWeight = 0.2;
    EXPECT_EQ(score(2.05, 0.05), 0);
    EXPECT_NEAR(score(1.9, 0.05), std::log(0.8 * std::exp(-0.5 * 0.25) + 0.2), 1e-5);
    EXPECT_NEAR(score(1.05, 0.05), std::log(0.8 * std::exp(-0.5 * 4) + 0.2), 1e-9);
    map.likelihoodOptions.sigma = 0.001;
    EXPECT_NEAR(score(1.05, 0.05), std::log(0.2), 1e-9);
    // Their ratio squared would be no number any more.
    for (const double sigma : {-1.0, 0.0, 1e-200, 1e200}) {
        map.likelihoodOptions.sigma = sigma;
        EXPECT_THROW(score(1, 1), std::invalid_argument) << sigma;
    }
    map.likelihoodOptions.sigma = 0.1;
    map.likelihoodOptions.maxDistance = 1e200;
    EXPECT_THROW(score(1, 1), std::invalid_argument);
    for (const double sigma : {1e-6, 1e6})
        for (const double distance : {1e-6, 1e6}) {
            map.likelihoodOptions.sigma = sigma;
            map.likelihoodOptions.maxDistance = distance;
            EXPECT_TRUE(std::isfinite(score(1.05, 0.05))) << sigma << ' ' << distance;
        }
}

TEST(Likelihood, DecimationAndLabels) {
    CSuperRayGridMap2D map(0.1);
    const auto scan = roomScan();
    ASSERT_TRUE(map.insertObservation(*scan));
    const CPose3D wrong(5, 0, 0, 0, 0, 0);
    const double all = map.computeObservationLikelihood(*scan, wrong);
    map.likelihoodOptions.decimation = 10;
    const double some = map.computeObservationLikelihood(*scan, wrong);
    EXPECT_LT(all, -100);
    EXPECT_NEAR(some / all, 0.1, 0.02);
    map.insertionOptions.sensorLabel = "OTHER";
    EXPECT_FALSE(map.canComputeObservationLikelihood(*scan));
    EXPECT_EQ(map.computeObservationLikelihood(*scan, wrong), 0);
    EXPECT_FALSE(map.canComputeObservationLikelihood(mrpt::obs::CObservationOdometry()));
}

mrpt::maps::CSimplePointsMap wallPoints() {
    mrpt::maps::CSimplePointsMap points;
    for (int i = 0; i < 20; ++i)
        points.insertPoint(2.05f, 0.1f * static_cast<float>(i) + 0.05f, 0.05f);
    return points;
}

TEST(Matching, RatioOfPointsNearOccupiedCells) {
    CSuperRayOctoMap map(0.1);
    auto points = wallPoints();
    mrpt::obs::CObservationPointCloud scan;
    scan.pointcloud = mrpt::maps::CSimplePointsMap::Create(points);
    ASSERT_TRUE(map.insertObservation(scan));
    ASSERT_EQ(map.cellTotals().occupied, 20u);
    mrpt::maps::TMatchingRatioParams params;
    params.maxDistForCorr = 0.15f;
    EXPECT_EQ(map.compute3DMatchingRatio(&points, CPose3D(), params), 1.0f);
    EXPECT_EQ(map.compute3DMatchingRatio(&points, CPose3D(0.15, 0, 0, 0, 0, 0), params), 1.0f);
    EXPECT_EQ(map.compute3DMatchingRatio(&points, CPose3D(0.4, 0, 0, 0, 0, 0), params), 0.0f);
    // 0.19 m before the wall, in a cell that reaches to 0.1 m of it.
    EXPECT_EQ(map.compute3DMatchingRatio(&points, CPose3D(-0.24, 0, 0, 0, 0, 0), params), 0.0f);
    EXPECT_EQ(map.compute3DMatchingRatio(&points, CPose3D(-0.19, 0, 0, 0, 0, 0), params), 1.0f);
    // Half of the wall shifted past its end.
    EXPECT_NEAR(map.compute3DMatchingRatio(&points, CPose3D(0, 1, 0, 0, 0, 0), params), 0.55f,
                0.051f);
    EXPECT_EQ(map.compute3DMatchingRatio(&map, CPose3D(), params), 1.0f) << "its own cells";
    EXPECT_EQ(map.compute3DMatchingRatio(nullptr, CPose3D(), params), 0.0f);
}

template <class Map>
void expectPairs() {
    Map map(0.1);
    auto points = wallPoints();
    mrpt::obs::CObservationPointCloud scan;
    scan.pointcloud = mrpt::maps::CSimplePointsMap::Create(points);
    ASSERT_TRUE(map.insertObservation(scan));
    mrpt::maps::TMatchingParams params;
    params.maxDistForCorrespondence = 0.3f;
    mrpt::tfest::TMatchingPairList pairs;
    mrpt::maps::TMatchingExtraResults extra;
    map.determineMatching3D(&points, CPose3D(-0.2, 0, 0, 0, 0, 0), pairs, params, extra);
    ASSERT_EQ(pairs.size(), 20u);
    EXPECT_EQ(extra.correspondencesRatio, 1.0f);
    for (const auto& pair : pairs) {
        EXPECT_NEAR(pair.global.x, 2.05, 1e-5);
        EXPECT_NEAR(pair.global.y, pair.local.y, 1e-5);
        EXPECT_NEAR(pair.global.z, 0.05, 1e-5);
        EXPECT_NEAR(pair.errorSquareAfterTransformation, 0.04, 1e-4);
    }
    params.decimation_other_map_points = 4;
    params.onlyUniqueRobust = true;
    map.determineMatching2D(&points, mrpt::poses::CPose2D(-0.2, 0, 0), pairs, params, extra);
    EXPECT_EQ(pairs.size(), 5u);
    EXPECT_EQ(extra.correspondencesRatio, 1.0f);
    map.determineMatching3D(&points, CPose3D(-0.6, 0, 0, 0, 0, 0), pairs, params, extra);
    EXPECT_TRUE(pairs.empty());
    EXPECT_EQ(extra.correspondencesRatio, 0.0f);
    // Another map of ours has points too: its occupied cells.
    params = {};
    params.maxDistForCorrespondence = 0.3f;
    map.determineMatching3D(&map, CPose3D(), pairs, params, extra);
    EXPECT_EQ(pairs.size(), map.cellTotals().occupied);
    const mrpt::maps::COctoMap pointless;
    EXPECT_THROW(map.determineMatching3D(&pointless, CPose3D(), pairs, params, extra),
                 std::invalid_argument);
}

TEST(Matching, PairsWithNearestOccupiedCells) {
    expectPairs<CSuperRayGridMap3D>();
    expectPairs<CSuperRayOctoMap>();
    expectPairs<CSuperRayGridMap2D>();
    expectPairs<CSuperRayQuadMap>();
}

}  // namespace
}  // namespace superray
