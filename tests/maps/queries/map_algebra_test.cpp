// SPDX-License-Identifier: BSD-3-Clause
// Parts of maps, and maps merged with a pose: cell by cell.

#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayQuadMap.h>

#include <Eigen/Geometry>
#include <map>
#include <set>
#include <unordered_set>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

template <class Map>
constexpr int dimensionOf = std::is_base_of_v<CSuperRayMapBase<3>, Map> ? 3 : 2;

template <int Dim>
using CellSet = std::unordered_set<Cell<Dim>, IndexHash>;

template <int Dim>
std::map<Cell<Dim>, float> cellsOf(const CSuperRayMapBase<Dim>& map) {
    std::map<Cell<Dim>, float> cells;
    map.storage().forEachBlock([&](const BlockView<Dim>& block) {
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (block.known.test(i)) cells[cellInBlock<Dim>(block.key, i)] = block.values[i];
    });
    return cells;
}

template <class Map>
class MapAlgebra : public ::testing::Test {
 protected:
    static constexpr int kDim = dimensionOf<Map>;
    static Map filled(unsigned seed, double resolution = 0.1) {
        Map map(resolution);
        for (unsigned i = 0; i < 2; ++i)
            EXPECT_TRUE(map.insertObservation(*test::randomCloud(200, seed + i)));
        return map;
    }
    /// What `to` has after `from` is added with cells moved by move(centre of a cell
    /// of `to`) = point in `from`.
    template <class Back>
    static std::map<Cell<kDim>, float> expected(const Map& to, const Map& from,
                                                const CellSet<kDim>& candidates, Back back) {
        auto cells = cellsOf<kDim>(to);
        const SensorModel model = to.sensorModel();
        for (const auto& c : candidates) {
            const Point<kDim> p = back(to.storage().geometry().center(c));
            if (!from.storage().geometry().contains(p)) continue;
            const auto v = from.storage().logOdds(from.storage().geometry().cellOf(p));
            if (!v) continue;
            const auto before = cells.find(c);
            const float sum = *v + (before == cells.end() ? 0.0f : before->second);
            cells[c] = std::min(model.max(), std::max(model.min(), sum));
        }
        return cells;
    }
};
using Maps = ::testing::Types<CSuperRayGridMap3D, CSuperRayOctoMap, CSuperRayGridMap2D,
                              CSuperRayQuadMap>;
TYPED_TEST_SUITE(MapAlgebra, Maps);

TYPED_TEST(MapAlgebra, SubMapsHaveTheCellsOfTheBox) {
    constexpr int Dim = dimensionOf<TypeParam>;
    auto map = this->filled(1);
    map.insertionOptions.maxrange = 7.25;
    map.likelihoodOptions.sigma = 0.33;
    const auto digest = map.digest();
    const MetricBounds box{{-1.52, -0.7, -0.4}, {0.95, 2.05, 1.6}};
    const auto part = map.subMap(box);
    EXPECT_EQ(part->GetRuntimeClass(), map.GetRuntimeClass());
    const auto& cut = dynamic_cast<const CSuperRayMapBase<Dim>&>(*part);
    EXPECT_EQ(cut.optionsAsIniText(), map.optionsAsIniText());
    EXPECT_EQ(cut.totals().scans, 0u);
    EXPECT_EQ(map.digest(), digest);
    const auto got = cellsOf<Dim>(cut);
    std::size_t inside = 0, outside = 0;
    for (const auto& [cell, value] : cellsOf<Dim>(map)) {
        const Point<Dim> p = map.storage().geometry().center(cell);
        bool in = true;
        for (int a = 0; a < Dim; ++a)
            in = in && p[a] >= box.lowest[a] && p[a] <= box.highest[a];
        const auto found = got.find(cell);
        ASSERT_EQ(found != got.end(), in);
        if (in) {
            ASSERT_EQ(found->second, value);
        }
        ++(in ? inside : outside);
    }
    EXPECT_EQ(got.size(), inside);
    EXPECT_GT(inside, 100u);
    EXPECT_GT(outside, 100u);
    EXPECT_TRUE(map.subMap({{50, 50, 50}, {60, 60, 60}})->isEmpty());
    EXPECT_THROW(map.subMap({{1, 0, 0}, {0, 1, 1}}), std::invalid_argument);
    EXPECT_THROW(map.subMap({{0, std::nan(""), 0}, {1, 1, 1}}), std::invalid_argument);
    // The part lives on by itself.
    ASSERT_TRUE(part->insertObservation(*test::randomCloud(50, 5)));
    EXPECT_EQ(map.digest(), digest);
}

TYPED_TEST(MapAlgebra, IdentityAndAlignedShiftsAreExact) {
    constexpr int Dim = dimensionOf<TypeParam>;
    const auto from = this->filled(1);
    TypeParam copy(0.1);
    copy.merge(from, CPose3D());
    EXPECT_EQ(copy.digest(), from.digest());

    for (const auto& shift : {Cell<3>{16, -3, 5}, Cell<3>{-1, 0, 1}, Cell<3>{300, 77, -9}}) {
        auto to = this->filled(20);
        CellSet<Dim> candidates;
        Point<Dim> t;
        for (int a = 0; a < Dim; ++a) t[a] = shift[static_cast<std::size_t>(a)] * 0.1;
        for (const auto& [cell, value] : cellsOf<Dim>(from)) {
            Cell<Dim> moved = cell;
            for (std::size_t a = 0; a < Dim; ++a) moved[a] += shift[a];
            candidates.insert(moved);
        }
        const auto expected = this->expected(
            to, from, candidates, [&](const Point<Dim>& p) -> Point<Dim> { return p - t; });
        const auto stamp = to.changeStamp();
        to.merge(from, CPose3D(t[0], t[1], Dim == 3 ? t[Dim - 1] : 0, 0, 0, 0));
        EXPECT_EQ(cellsOf<Dim>(to), expected);
        ASSERT_EQ(candidates.size(), cellsOf<Dim>(from).size());
        std::set<BlockKey<Dim>> changed;
        EXPECT_TRUE(to.forEachChangedBlock(stamp, [&](const auto& k) { changed.insert(k); }));
        for (const auto& c : candidates) EXPECT_TRUE(changed.count(blockOf<Dim>(c)));
    }
}

TYPED_TEST(MapAlgebra, AnyPoseAndResolutionTakesTheCellAtTheCentre) {
    constexpr int Dim = dimensionOf<TypeParam>;
    for (const double resolution : {0.1, 0.16}) {
        auto to = this->filled(30);
        const auto from = this->filled(1, resolution);
        const double yaw = 0.7, pitch = Dim == 3 ? -0.3 : 0, roll = Dim == 3 ? 0.2 : 0;
        const CPose3D pose(0.37, -1.21, Dim == 3 ? 0.55 : 0, yaw, pitch, roll);
        const Eigen::Matrix3d R = (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                                   Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                                   Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
                                      .toRotationMatrix();
        // Every cell whose centre may lie in a moved cell.
        CellSet<Dim> candidates;
        for (const auto& entry : cellsOf<Dim>(from)) {
            Eigen::Vector3d p = Eigen::Vector3d::Zero();
            p.head<Dim>() = from.storage().geometry().center(entry.first);
            const Eigen::Vector3d q = R * p + Eigen::Vector3d(pose.x(), pose.y(), pose.z());
            const Cell<Dim> middle = to.storage().geometry().cellOf(q.head<Dim>());
            for (int i = 0; i < (Dim == 3 ? 125 : 25); ++i) {
                Cell<Dim> c = middle;
                for (int a = 0, rest = i; a < Dim; ++a, rest /= 5)
                    c[static_cast<std::size_t>(a)] += rest % 5 - 2;
                candidates.insert(c);
            }
        }
        const auto expected =
            this->expected(to, from, candidates, [&](const Point<Dim>& p) -> Point<Dim> {
                Eigen::Vector3d q = -Eigen::Vector3d(pose.x(), pose.y(), pose.z());
                q.head<Dim>() += p;
                return (R.transpose() * q).template head<Dim>();
            });
        to.merge(from, pose);
        const auto got = cellsOf<Dim>(to);
        // Centres that lie on a border of a cell may be rounded to either side.
        std::size_t differ = 0;
        for (const auto& [cell, value] : expected) {
            const auto found = got.find(cell);
            differ += found == got.end() || found->second != value ? 1 : 0;
        }
        EXPECT_LE(differ, expected.size() / 1000);
        EXPECT_NEAR(static_cast<double>(got.size()), static_cast<double>(expected.size()),
                    1e-3 * static_cast<double>(expected.size()));
        EXPECT_GT(expected.size(), 1000u);
    }
}

TYPED_TEST(MapAlgebra, WhatCannotBeMergedChangesNothing) {
    constexpr int Dim = dimensionOf<TypeParam>;
    auto map = this->filled(1);
    const auto digest = map.digest();
    const auto stamp = map.changeStamp();
    EXPECT_THROW(map.merge(map, CPose3D(3275, 0, 0, 0, 0, 0)), std::invalid_argument);
    EXPECT_THROW(map.merge(map, CPose3D(std::nan(""), 0, 0, 0, 0, 0)), std::invalid_argument);
    EXPECT_THROW(map.merge(mrpt::maps::CSimplePointsMap(), CPose3D()), std::invalid_argument);
    if (Dim == 2) {
        EXPECT_THROW(map.merge(CSuperRayGridMap3D(), CPose3D()), std::invalid_argument);
        EXPECT_THROW(map.merge(map, CPose3D(0, 0, 0, 0, 0.1, 0)), std::invalid_argument);
        EXPECT_THROW(map.merge(map, CPose3D(0, 0, 1, 0, 0, 0)), std::invalid_argument);
    } else {
        EXPECT_THROW(map.merge(CSuperRayGridMap2D(), CPose3D()), std::invalid_argument);
    }
    map.merge(TypeParam(0.1), CPose3D());
    EXPECT_EQ(map.digest(), digest);
    EXPECT_EQ(map.changeStamp(), stamp);
    map.merge(map, CPose3D());  // itself: every value doubled, and clamped
    EXPECT_NE(map.digest(), digest);
}

TEST(MapAlgebraMixed, StorageTypesMerge) {
    CSuperRayGridMap3D grid(0.1);
    ASSERT_TRUE(grid.insertObservation(*test::randomCloud(300, 1)));
    CSuperRayOctoMap tree(0.1);
    tree.merge(grid, CPose3D());
    EXPECT_EQ(tree.digest(), grid.digest());
}

}  // namespace
}  // namespace superray
