// SPDX-License-Identifier: BSD-3-Clause
// Queries whose distances or points are no sensible numbers.

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPose2D.h>
#include <mrpt/tfest/TMatchingPair.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>

#include <chrono>
#include <cmath>
#include <limits>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNoDistances[] = {-0.05f, -0.2f, -1.0f, -kInf, kNan};

template <class Map>
class OddDistances : public ::testing::Test {
 protected:
    OddDistances() {
        const auto scan = test::randomCloud(60, 1);
        map_.insertObservation(*scan, CPose3D());
        const mrpt::maps::CSimplePointsMap cells = *map_.getAsSimplePointsMap();
        points_.changeCoordinatesReference(cells, CPose3D());
    }
    std::size_t pairs(float distance, float angle) const {
        mrpt::tfest::TMatchingPairList found, foundIn2D;
        mrpt::maps::TMatchingParams params;
        params.maxDistForCorrespondence = distance;
        params.maxAngularDistForCorrespondence = angle;
        float x = 0, y = 0, z = 0;
        points_.getPoint(0, x, y, z);
        params.angularDistPivotPoint = {x, y, z};
        mrpt::maps::TMatchingExtraResults extra;
        map_.determineMatching3D(&points_, CPose3D(), found, params, extra);
        map_.determineMatching2D(&points_, mrpt::poses::CPose2D(), foundIn2D, params, extra);
        EXPECT_EQ(found.size(), foundIn2D.size());
        return found.size();
    }

    Map map_{0.2};
    mrpt::maps::CSimplePointsMap points_;  // the centres of the occupied cells
};
using Maps = ::testing::Types<CSuperRayGridMap2D, CSuperRayGridMap3D>;
TYPED_TEST_SUITE(OddDistances, Maps);

TYPED_TEST(OddDistances, NothingIsWithinANegativeDistanceOrNaN) {
    const auto start = std::chrono::steady_clock::now();
    for (const float distance : kNoDistances) {
        mrpt::maps::TMatchingRatioParams params;
        params.maxDistForCorr = distance;
        EXPECT_EQ(this->map_.compute3DMatchingRatio(&this->points_, CPose3D(), params), 0.0f)
            << distance;
        EXPECT_EQ(this->pairs(distance, 0), 0u) << distance;
        EXPECT_EQ(this->pairs(distance, -0.1f), 0u) << distance;
        if (std::isnan(distance)) {
            EXPECT_EQ(this->pairs(0.1f, distance), 0u);
        }
        NeighborQuery query;
        query.squaredRadius = double{distance};
        EXPECT_TRUE(this->map_.neighbors(query).empty()) << distance;
    }
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TYPED_TEST(OddDistances, AnglesAddToTheDistance) {
    const std::size_t all = this->points_.size();
    EXPECT_EQ(this->pairs(0.1f, 0), all);
    // The first point is the pivot.
    EXPECT_EQ(this->pairs(0.1f, -10.0f), 1u);
    EXPECT_EQ(this->pairs(0.1f, kInf), all);
    EXPECT_EQ(this->pairs(-0.1f, kInf), all - 1);
    EXPECT_EQ(this->pairs(kInf, 0), all);
    EXPECT_EQ(this->pairs(kInf, -kInf), 1u);
}

TYPED_TEST(OddDistances, NoCellIsNearAPointThatIsNotFinite) {
    const TypeParam empty(0.2);
    for (const float odd : {kNan, kInf, -kInf}) {
        EXPECT_EQ(this->map_.squareDistanceToClosestCorrespondence(odd, odd), kInf) << odd;
        EXPECT_EQ(this->map_.squareDistanceToClosestCorrespondence(odd, 0), kInf) << odd;
        EXPECT_EQ(this->map_.squareDistanceToClosestCorrespondence(0, odd), kInf) << odd;
        EXPECT_EQ(empty.squareDistanceToClosestCorrespondence(odd, 0), kInf) << odd;
        NeighborQuery query;
        query.point.x() = double{odd};
        EXPECT_TRUE(this->map_.neighbors(query).empty()) << odd;
    }
    EXPECT_LT(this->map_.squareDistanceToClosestCorrespondence(0, 0), 100.0f);
}

}  // namespace
}  // namespace superray
