// SPDX-License-Identifier: BSD-3-Clause
// Questions to a map: against brute force over all cells, and against OctoMap.

#include <octomap/OcTree.h>
#include <superray/core/traversal.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayQuadMap.h>

#include <map>

#include "maps/test_scans.h"

namespace superray {
namespace {

template <class Map>
constexpr int dimensionOf = std::is_base_of_v<CSuperRayMapBase<3>, Map> ? 3 : 2;

template <class Map>
class MapQueries : public ::testing::Test {
 protected:
    static constexpr int kDim = dimensionOf<Map>;
    Map map_{0.1};
    std::mt19937 random_{42};

    void SetUp() override {
        map_.insertionOptions.setPolicy(UpdatePolicy::everyRay);  // leaves gaps to see through
        for (unsigned i = 0; i < 3; ++i)
            ASSERT_TRUE(map_.insertObservation(*test::randomCloud(300, i)));
        ASSERT_GT(map_.cellTotals().occupied, 100u);
    }
    Eigen::Vector3d randomPoint(double extent) {
        std::uniform_real_distribution<double> u(-extent, extent);
        return {u(random_), u(random_), kDim == 3 ? u(random_) : 0};
    }
    template <class F>
    void forEachCell(F f) const {
        map_.storage().forEachBlock([&](const BlockView<kDim>& block) {
            for (int i = 0; i < kBlockCells<kDim>; ++i)
                if (block.known.test(i)) f(cellInBlock<kDim>(block.key, i), block.values[i]);
        });
    }
    Eigen::Vector3d center(const Cell<kDim>& c) const {
        Eigen::Vector3d p = Eigen::Vector3d::Zero();
        p.head<kDim>() = map_.storage().geometry().center(c);
        return p;
    }
    Cell<kDim> cellOf(const Eigen::Vector3d& p) const {
        return map_.storage().geometry().cellOf(p.head<kDim>());
    }
};
using Maps = ::testing::Types<CSuperRayGridMap3D, CSuperRayOctoMap, CSuperRayGridMap2D,
                              CSuperRayQuadMap>;
TYPED_TEST_SUITE(MapQueries, Maps);

TYPED_TEST(MapQueries, OccupancyAtAPoint) {
    constexpr int Dim = dimensionOf<TypeParam>;
    this->map_.insertionOptions.occupancyThres = 0.6;
    const auto& map = this->map_;
    std::size_t occupied = 0;
    this->forEachCell([&](const Cell<Dim>& c, float value) {
        auto p = this->center(c);
        if (Dim == 2) p.z() = 1e9;  // ignored
        const auto probability = map.occupancyAt(p);
        ASSERT_TRUE(probability);
        EXPECT_EQ(*probability, probabilityOf(value));
        EXPECT_EQ(map.isOccupied(p), value >= logOddsOf(0.6));
        occupied += map.isOccupied(p) ? 1 : 0;
    });
    EXPECT_EQ(occupied, map.cellTotals().occupied);
    EXPECT_GT(occupied, 0u);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(1000, 0, 0), Eigen::Vector3d(1e9, 0, 0),
                                     Eigen::Vector3d(0, nan, 0)}) {
        EXPECT_FALSE(map.occupancyAt(p));
        EXPECT_FALSE(map.isOccupied(p));
    }
}

TYPED_TEST(MapQueries, NearestObstacle) {
    constexpr int Dim = dimensionOf<TypeParam>;
    std::vector<Eigen::Vector3d> centers;
    this->forEachCell([&](const Cell<Dim>& c, float v) {
        if (v >= 0) centers.push_back(this->center(c));
    });
    std::size_t near = 0, far = 0;
    for (int i = 0; i < 300; ++i) {
        const auto p = this->randomPoint(i % 2 == 0 ? 5 : 60);
        const auto own = this->center(this->cellOf(p));
        double best = 1e9;
        for (const auto& c : centers) best = std::min(best, (c - own).norm());
        const auto found =
            this->map_.nearestObstacle(p, std::numeric_limits<double>::infinity());
        ASSERT_TRUE(found);
        EXPECT_NEAR((found->cellCenter - own).norm(), best, 1e-9);
        const Eigen::Vector3d gap =
            ((p - found->cellCenter).cwiseAbs().array() - 0.05).max(0).matrix();
        EXPECT_NEAR(found->distance, gap.head<Dim>().norm(), 1e-9);
        ++(found->distance < 2 ? near : far);
        const auto within = this->map_.nearestObstacle(p, 0.4);
        EXPECT_EQ(within.has_value(), found->distance <= 0.4);
        if (within) {
            EXPECT_NEAR(within->distance, found->distance, 1e-9);
        }
    }
    EXPECT_GT(near, 50u);
    EXPECT_GT(far, 50u);
    EXPECT_FALSE(this->map_.nearestObstacle({1e9, 0, 0}, 10));
    EXPECT_THROW(this->map_.nearestObstacle({0, 0, 0}, -1), std::invalid_argument);
    EXPECT_FALSE(TypeParam(0.1).nearestObstacle({0, 0, 0}, 1e9));
}

TYPED_TEST(MapQueries, NearestObstacleAtTheBorderOfTheAddressableCells) {
    constexpr int Dim = dimensionOf<TypeParam>;
    const double all = std::numeric_limits<double>::infinity();
    Eigen::Vector3d obstacle = Eigen::Vector3d::Zero();
    obstacle.head<Dim>().setConstant((kCellLimit - 0.5) * 0.1);  // the last cell
    RayBundle<Dim> rays(CellGeometry<Dim>(0.1),
                        Point<Dim>(obstacle.head<Dim>() - Point<Dim>::Constant(1)));
    rays.add(obstacle.head<Dim>());
    TypeParam map(0.1);
    map.insertRays(rays);
    ASSERT_TRUE(map.isOccupied(obstacle));
    // Beside it, at the other border, and outside of the cells.
    for (const double offset : {-0.15, -5.0, -2 * 3276.7, 0.15, 40.0, 1e6}) {
        Eigen::Vector3d p = obstacle;
        p.x() += offset;
        const auto found = map.nearestObstacle(p, all);
        ASSERT_TRUE(found) << offset;
        EXPECT_LT((found->cellCenter - obstacle).norm(), 1e-9);
        EXPECT_NEAR(found->distance, std::abs(offset) - 0.05, 1e-6);
        EXPECT_FALSE(map.nearestObstacle(p, std::abs(offset) - 0.06));
        EXPECT_TRUE(map.nearestObstacle(p, std::abs(offset)));
    }
    EXPECT_TRUE(map.nearestObstacle({1e140, -1e140, 0}, all));
    // Squares of such distances are no doubles.
    EXPECT_FALSE(map.nearestObstacle({1e300, 0, 0}, all));
    EXPECT_FALSE(map.nearestObstacle({all, 0, 0}, all));
}

TYPED_TEST(MapQueries, SquaredDistanceFromAbove) {
    constexpr int Dim = dimensionOf<TypeParam>;
    for (int i = 0; i < 50; ++i) {
        const auto p = this->randomPoint(20);
        double best = 1e9;
        this->forEachCell([&](const Cell<Dim>& c, float v) {
            if (v >= 0)
                best = std::min(best, (this->center(c) - p).template head<2>().squaredNorm());
        });
        EXPECT_NEAR(this->map_.squareDistanceToClosestCorrespondence(static_cast<float>(p.x()),
                                                                     static_cast<float>(p.y())),
                    best, 1e-4 * best + 1e-6);
    }
    EXPECT_EQ(TypeParam(0.1).squareDistanceToClosestCorrespondence(0, 0),
              std::numeric_limits<float>::infinity());
}

TYPED_TEST(MapQueries, PointsAreTheOccupiedCells) {
    constexpr int Dim = dimensionOf<TypeParam>;
    const auto expectAll = [&] {
        const auto* points = std::as_const(this->map_).getAsSimplePointsMap();
        ASSERT_TRUE(points);
        EXPECT_EQ(points->size(), this->map_.cellTotals().occupied);
        for (std::size_t i = 0; i < points->size(); ++i) {
            float x = 0, y = 0, z = 0;
            points->getPoint(i, x, y, z);
            const Cell<Dim> cell = this->cellOf({x, y, z});
            ASSERT_GE(this->map_.storage().logOdds(cell).value(), 0);
            EXPECT_LT((this->center(cell) - Eigen::Vector3d(x, y, z)).norm(), 1e-5);
        }
    };
    expectAll();
    ASSERT_TRUE(this->map_.insertObservation(*test::randomCloud(100, 99)));
    expectAll();
    this->map_.insertionOptions.occupancyThres = 0.8;
    expectAll();
    this->map_.clear();
    EXPECT_EQ(this->map_.getAsSimplePointsMap()->size(), 0u);
}

TYPED_TEST(MapQueries, RaysMeetTheFirstCellOfTheirLine) {
    constexpr int Dim = dimensionOf<TypeParam>;
    const auto& geometry = this->map_.storage().geometry();
    std::map<RayCastEnd, std::size_t> ends;
    for (int i = 0; i < 1000; ++i) {
        const auto origin = this->randomPoint(2), direction = this->randomPoint(1);
        const double range = i % 4 == 0 ? 1.5 : 8;
        const auto policy = i % 2 == 0 ? UnknownCells::pass : UnknownCells::stop;
        const auto cast = this->map_.castRay(origin, direction, range, policy);
        ++ends[cast.end];

        // The cells of an inserted ray of the same ends.
        const Eigen::Vector3d end = origin + range * direction.normalized();
        Units<Dim> from, to;
        for (int a = 0; a < Dim; ++a) {
            from[static_cast<std::size_t>(a)] = toUnits(geometry.scaled(origin[a]));
            to[static_cast<std::size_t>(a)] = toUnits(geometry.scaled(end[a]));
        }
        const RayLine<Dim> line(from, to);
        std::vector<Cell<Dim>> cells;
        forEachFreeCell(line, [&](const Cell<Dim>& c) { cells.push_back(c); });
        cells.push_back(line.endCell());
        RayCastEnd expected = RayCastEnd::nothing;
        Cell<Dim> met = cells.back();
        for (const auto& c : cells) {
            const auto v = this->map_.storage().logOdds(c);
            if (v ? *v < 0 : policy == UnknownCells::pass) continue;
            expected = v ? RayCastEnd::hit : RayCastEnd::unknown;
            met = c;
            break;
        }
        ASSERT_EQ(cast.end, expected);
        EXPECT_LT((cast.cellCenter - this->center(met)).norm(), 1e-9);
        Eigen::Vector3d along = direction;
        if (Dim == 2) along.z() = 0;
        Eigen::Vector3d start = origin;
        if (Dim == 2) start.z() = 0;
        EXPECT_LT((cast.point - (start + cast.distance * along.normalized())).norm(), 1e-9);
        if (cast.end == RayCastEnd::nothing) {
            EXPECT_NEAR(cast.distance, range, 1e-9);
        } else {
            // On the cell's border (or at the origin), to the resolution of the line.
            const double outside =
                ((cast.point - cast.cellCenter).cwiseAbs().array() - 0.05).maxCoeff();
            EXPECT_LT(outside, 1e-6);
            EXPECT_TRUE(cast.distance == 0 || outside > -1e-6);
        }
    }
    EXPECT_GT(ends[RayCastEnd::hit], 20u);
    EXPECT_GT(ends[RayCastEnd::unknown], 20u);
    EXPECT_GT(ends[RayCastEnd::nothing], 20u);
}

TYPED_TEST(MapQueries, DirectionsOfAnyLengthAreTheSame) {
    for (const Eigen::Vector3d& direction :
         {Eigen::Vector3d(1, 0.5, 0.25), Eigen::Vector3d(-0.3, 1, 0.1)}) {
        const auto cast = [&](double length) {
            return this->map_.castRay({0, 0, 0}, length * direction, 20, UnknownCells::pass);
        };
        const RayCastResult expected = cast(1);
        for (const double length : {1e-310, 1e-200, 1e-5, 3.0, 1e200, 1e308}) {
            const RayCastResult result = cast(length);
            EXPECT_EQ(result.end, expected.end) << length;
            EXPECT_EQ(result.cellCenter, expected.cellCenter) << length;
            EXPECT_NEAR(result.distance, expected.distance, 1e-9) << length;
        }
    }
}

TYPED_TEST(MapQueries, RaysWithoutEndStopAtTheBorder) {
    const auto cast = this->map_.castRay({0, 0, 0}, {0, 1, 0}, 1e9, UnknownCells::pass);
    EXPECT_TRUE(cast.end == RayCastEnd::hit || std::abs(cast.distance - 3276.8) < 0.2);
    const double all = std::numeric_limits<double>::infinity();
    const auto away = this->map_.castRay({30, 30, 0}, {1, 0.5, 0}, all, UnknownCells::pass);
    EXPECT_EQ(away.end, RayCastEnd::nothing);
    EXPECT_NEAR(away.point.x(), 3276.8, 0.2);
    const auto cast1 = [&](const Eigen::Vector3d& o, const Eigen::Vector3d& d, double range) {
        this->map_.castRay(o, d, range, UnknownCells::pass);
    };
    EXPECT_THROW(cast1({1e5, 0, 0}, {1, 0, 0}, 1), std::invalid_argument);
    EXPECT_THROW(cast1({0, 0, 0}, {0, 0, 0}, 1), std::invalid_argument);
    EXPECT_THROW(cast1({0, 0, 0}, {1, 0, 0}, 0), std::invalid_argument);
    EXPECT_THROW(cast1({0, 0, 0}, {std::nan(""), 0, 0}, 1), std::invalid_argument);
}

/// What OctoMap's inner nodes would hold if they were means.
double meanOf(const octomap::OcTree& tree, const octomap::OcTreeNode* node) {
    if (!tree.nodeHasChildren(node)) return node->getOccupancy();
    double sum = 0;
    int n = 0;
    for (unsigned i = 0; i < 8; ++i)
        if (tree.nodeChildExists(node, i)) {
            sum += meanOf(tree, tree.getNodeChild(node, i));
            ++n;
        }
    return sum / n;
}

TEST(MapLevels, AgreeWithTheNodesOfOctoMap) {
    CSuperRayOctoMap tree(0.1);
    CSuperRayGridMap3D grid(0.1);
    for (unsigned i = 0; i < 3; ++i) {
        ASSERT_TRUE(tree.insertObservation(*test::randomCloud(300, i)));
        ASSERT_TRUE(grid.insertObservation(*test::randomCloud(300, i)));
    }
    std::mt19937 random(7);
    std::uniform_real_distribution<double> u(-6, 6);
    std::size_t known = 0, unknown = 0;
    const auto expectLevel = [&](const Eigen::Vector3d& p, unsigned level) {
        const auto* node = tree.octree().search(p.x(), p.y(), p.z(), 16 - level);
        const auto highest = grid.logOddsAtLevel(p, level, LevelRule::maximum);
        const auto mean = grid.logOddsAtLevel(p, level, LevelRule::mean);
        ASSERT_EQ(highest.has_value(), node != nullptr) << "level " << level;
        ASSERT_EQ(mean.has_value(), node != nullptr);
        EXPECT_EQ(tree.logOddsAtLevel(p, level, LevelRule::maximum), highest);
        ++(node ? known : unknown);
        if (!node) return;
        EXPECT_EQ(*highest, node->getLogOdds());
        EXPECT_NEAR(probabilityOf(*mean), meanOf(tree.octree(), node), 1e-5);
        EXPECT_NEAR(*tree.logOddsAtLevel(p, level, LevelRule::mean), *mean, 1e-5);
    };
    for (unsigned level = 0; level <= 10; ++level)
        for (int i = 0; i < (level < 7 ? 60 : 5); ++i)
            expectLevel({u(random), u(random), u(random)}, level);
    expectLevel({1, 1, 1}, 15);
    EXPECT_GT(known, 100u);
    EXPECT_GT(unknown, 50u);
    EXPECT_THROW(grid.logOddsAtLevel({0, 0, 0}, 17, LevelRule::mean), std::invalid_argument);
    EXPECT_FALSE(grid.logOddsAtLevel({1e9, 0, 0}, 3, LevelRule::mean));
}

TEST(MapLevels, WholeMapAtTheCoarsestLevelOfTheTwoDimensionalMaps) {
    CSuperRayGridMap2D grid(0.1);
    CSuperRayQuadMap tree(0.1);
    for (auto* map :
         {static_cast<CSuperRayMapBase<2>*>(&grid), static_cast<CSuperRayMapBase<2>*>(&tree)}) {
        ASSERT_TRUE(map->insertObservation(*test::randomCloud(300, 1)));
        float highest = -10;
        map->storage().forEachBlock([&](const BlockView<2>& block) {
            for (int i = 0; i < kBlockCells<2>; ++i)
                // Level 15 cubes meet at the origin.
                if (block.known.test(i) && block.key[0] >= 0 && block.key[1] >= 0)
                    highest = std::max(highest, block.values[i]);
        });
        EXPECT_EQ(map->logOddsAtLevel({1, 1, 0}, 15, LevelRule::maximum), highest);
    }
}

}  // namespace
}  // namespace superray
