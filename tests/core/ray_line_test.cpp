// SPDX-License-Identifier: BSD-3-Clause
// The digital line and the walk along it: cells by hand, geometry, and the
// reference walk, in both dimensions.

#include <superray/core/ray_line.h>
#include <superray/core/reference_mapper.h>
#include <superray/core/traversal.h>

#include <gtest/gtest.h>

#include "core/dims.h"
#include "core/ray_generators.h"

namespace superray {
namespace {

using test::Random;

template <int Dim>
std::vector<Cell<Dim>> freeCells(const CellGeometry<Dim>& g, const Point<Dim>& o,
                                 const Point<Dim>& e, std::int32_t firstSlice = 0) {
    std::vector<Cell<Dim>> cells;
    const RayLine<Dim> line(g, o, e);
    forEachFreeCell(line, firstSlice, line.slices(),
                    [&](const Cell<Dim>& c) { cells.push_back(c); });
    return cells;
}

TEST(RayLine, CellsByHandIn2D) {
    const CellGeometry<2> g(1.0);
    // Up to the right, slope 1/2: enters row 1 at x = 1.9.
    EXPECT_EQ(freeCells<2>(g, {0.5, 0.3}, {3.5, 1.8}),
              (std::vector<Cell<2>>{{0, 0}, {1, 0}, {1, 1}, {2, 1}}));
    // The same backwards visits the same cells from the other end.
    EXPECT_EQ(freeCells<2>(g, {3.5, 1.8}, {0.5, 0.3}),
              (std::vector<Cell<2>>{{3, 1}, {2, 1}, {1, 1}, {1, 0}}));
    // Axis-aligned, downwards, across zero.
    EXPECT_EQ(freeCells<2>(g, {0.5, 1.5}, {0.5, -1.5}),
              (std::vector<Cell<2>>{{0, 1}, {0, 0}, {0, -1}}));
    // An exact diagonal meets corners: x is major, so y steps first.
    EXPECT_EQ(freeCells<2>(g, {0.5, 0.5}, {2.5, 2.5}),
              (std::vector<Cell<2>>{{0, 0}, {0, 1}, {1, 1}, {1, 2}}));
}

TEST(RayLine, CellsByHandIn3D) {
    const CellGeometry<3> g(1.0);
    // Corner tie of all three axes: z, then y, then the major x.
    EXPECT_EQ(freeCells<3>(g, {0.5, 0.5, 0.5}, {1.5, 1.5, 1.5}),
              (std::vector<Cell<3>>{{0, 0, 0}, {0, 0, 1}, {0, 1, 1}}));
    EXPECT_EQ(freeCells<3>(g, {0.5, 0.5, 0.5}, {-0.5, 0.5, 0.5}),
              (std::vector<Cell<3>>{{0, 0, 0}}));
    EXPECT_TRUE(freeCells<3>(g, {0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}).empty());
    EXPECT_TRUE(freeCells<3>(g, {0.1, 0.5, 0.5}, {0.9, 0.2, 0.7}).empty());
}

TEST(RayLine, UnitsKeepTheCell) {
    Random random(1);
    int tested = 0;
    for (int i = 0; i < 100000; ++i) {
        double s = test::uniform(random, -kCellLimit, kCellLimit);
        if (i % 3 == 0) s = std::round(s);
        if (i % 7 == 0) s = std::nextafter(std::round(s), -1e9);
        if (s < -kCellLimit || s >= kCellLimit) continue;
        ASSERT_EQ(toUnits(s) >> kUnitBits, static_cast<std::int64_t>(std::floor(s))) << s;
        ASSERT_EQ(toUnits(s) & 1, 1);
        ++tested;
    }
    EXPECT_GT(tested, 99000);
}

/// Largest distance, along one axis [cells], by which the segment misses a cell
/// it is said to pass: slab test with the widest slack needed.
template <int Dim>
double missDistance(const CellGeometry<Dim>& g, const Point<Dim>& o, const Point<Dim>& e,
                    const Cell<Dim>& c) {
    using Real = long double;
    double lo = 0, hi = 1;  // bisect the slack
    for (int it = 0; it < 60; ++it) {
        const double slack = (lo + hi) / 2;
        Real t0 = 0, t1 = 1;
        for (int a = 0; a < Dim; ++a) {
            const Real from = g.scaled(o[a]), d = Real(g.scaled(e[a])) - from;
            const Real low = c[a] - Real(slack), high = c[a] + 1 + Real(slack);
            if (d == 0) {
                if (from < low || from > high) t1 = -1;
            } else {
                Real ta = (low - from) / d, tb = (high - from) / d;
                if (ta > tb) std::swap(ta, tb);
                t0 = std::max(t0, ta);
                t1 = std::min(t1, tb);
            }
        }
        (t0 <= t1 ? hi : lo) = slack;
    }
    return hi;
}

template <typename T>
class RayLineWalk : public ::testing::Test {};
TYPED_TEST_SUITE(RayLineWalk, test::Dims);

TYPED_TEST(RayLineWalk, IsConnectedExactAndStartsAnywhere) {
    constexpr int Dim = TypeParam::value;
    Random random(20);
    const CellGeometry<Dim> g(0.1);
    int rays = 0;
    for (int round = 0; round < 20; ++round) {
        for (test::Scene scene : test::kScenes) {
            const RayBundle<Dim> scan = test::makeScan<Dim>(scene, random, g, 100);
            for (std::size_t i = 0; i < scan.size(); ++i, ++rays) {
                const Point<Dim>&o = scan.origin(i), &e = scan.end(i);
                const RayLine<Dim> line(g, o, e);
                ASSERT_EQ(line.startCell(), g.cellOf(o));
                ASSERT_EQ(line.endCell(), g.cellOf(e));
                std::vector<Cell<Dim>> cells = freeCells<Dim>(g, o, e);
                ASSERT_EQ(static_cast<std::int64_t>(cells.size()), line.steps());

                // The reference walk, one step at a time, sees the same cells.
                RayBundle<Dim> one(g, o);
                one.add(e, RayEnd::noReturn);
                const CellCountMap<Dim> reference = countCells(one);
                ASSERT_EQ(reference.size(), cells.size());
                for (const Cell<Dim>& c : cells) ASSERT_EQ(reference.count(c), 1u);

                // Starting in the middle gives a suffix of the walk.
                const auto suffix =
                    freeCells<Dim>(g, o, e, test::integer(random, 0, line.slices() - 1));
                ASSERT_TRUE(std::equal(suffix.rbegin(), suffix.rend(), cells.rbegin()));

                cells.push_back(g.cellOf(e));
                for (std::size_t k = 0; k < cells.size(); ++k) {
                    ASSERT_LT(missDistance<Dim>(g, o, e, cells[k]), 1e-6);
                    if (k == 0) continue;
                    int steps = 0;
                    for (int a = 0; a < Dim; ++a)
                        steps += std::abs(cells[k][a] - cells[k - 1][a]);
                    ASSERT_EQ(steps, 1);
                }
            }
        }
    }
    EXPECT_EQ(rays, 20 * 7 * 100);
}

TYPED_TEST(RayLineWalk, LongestRaysStayWithinAGraze) {
    constexpr int Dim = TypeParam::value;
    Random random(21);
    const CellGeometry<Dim> g(0.01);
    const double edge = kCellLimit * 0.01;
    int rays = 0;
    for (int i = 0; i < 6; ++i, ++rays) {
        const Point<Dim> o = test::uniformPoint<Dim>(random, edge * 0.999);
        const Point<Dim> e = -o;
        std::size_t k = 0;
        Cell<Dim> last{};
        forEachFreeCell(RayLine<Dim>(g, o, e), [&](const Cell<Dim>& c) {
            if (++k % 97 == 0) {
                ASSERT_LT(missDistance<Dim>(g, o, e, c), 1e-4);
            }
            last = c;
        });
        EXPECT_EQ(static_cast<std::int64_t>(k), RayLine<Dim>(g, o, e).steps());
    }
    EXPECT_EQ(rays, 6);
}

}  // namespace
}  // namespace superray
