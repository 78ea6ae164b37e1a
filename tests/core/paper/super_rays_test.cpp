// SPDX-License-Identifier: BSD-3-Clause
// Super rays: weights add up, merged rays have the same cells for certain,
// and grouping does happen.

#include <superray/core/reference_mapper.h>
#include <superray/core/super_rays.h>
#include <superray/core/traversal.h>

#include <gtest/gtest.h>

#include "core/dims.h"
#include "core/ray_generators.h"

namespace superray {
namespace {

using test::Random;

template <int Dim>
std::vector<Cell<Dim>> walk(const RayBundle<Dim>& rays, std::size_t i) {
    const RayLine<Dim> line(rays.geometry(), rays.origin(i), rays.end(i));
    std::vector<Cell<Dim>> cells;
    forEachFreeCell(line, [&](const Cell<Dim>& c) { cells.push_back(c); });
    cells.push_back(line.endCell());
    return cells;
}

template <typename T>
class SuperRays : public ::testing::Test {};
TYPED_TEST_SUITE(SuperRays, test::Dims);

TYPED_TEST(SuperRays, WeightsOfEqualWalksAddUpToTheScan) {
    constexpr int Dim = TypeParam::value;
    Random random(30);
    const CellGeometry<Dim> g(0.1);
    SuperRayGrouper<Dim> grouper;
    std::uint64_t rays = 0, grouped = 0;
    for (int round = 0; round < 10; ++round) {
        for (test::Scene scene : test::kScenes) {
            for (std::uint32_t k : {1u, 2u, 20u}) {
                const RayBundle<Dim> scan = test::makeScan<Dim>(scene, random, g, 600);
                const auto& supers = grouper.group(scan, k);
                // The counts of the super rays, weighted, are those of the rays.
                CellCountMap<Dim> counts;
                std::uint64_t weights = 0;
                for (const SuperRay& s : supers) {
                    std::vector<Cell<Dim>> cells = walk(scan, s.ray);
                    if (scan.kind(s.ray) == RayEnd::hit) counts[cells.back()].hits += s.weight;
                    cells.pop_back();
                    for (const Cell<Dim>& c : cells) counts[c].misses += s.weight;
                    weights += s.weight;
                }
                ASSERT_EQ(weights, scan.size());
                const CellCountMap<Dim> reference = countCells(scan);
                ASSERT_EQ(counts.size(), reference.size());
                for (const auto& [cell, count] : reference) {
                    ASSERT_EQ(counts[cell].misses, count.misses);
                    ASSERT_EQ(counts[cell].hits, count.hits);
                }
                rays += scan.size();
                if (k == 1) grouped += scan.size() - supers.size();
            }
        }
    }
    EXPECT_EQ(rays, 10u * 7 * 3 * 600);
    EXPECT_GT(grouped, rays / 30);
}

TYPED_TEST(SuperRays, ADenseFarCellBecomesFewSuperRays) {
    constexpr int Dim = TypeParam::value;
    Random random(31);
    const CellGeometry<Dim> g(0.1);
    Point<Dim> origin = Point<Dim>::Constant(0.03);
    RayBundle<Dim> scan(g, origin);
    Cell<Dim> far{};
    far.fill(7);
    far[0] = 20;
    for (int i = 0; i < 2000; ++i)
        scan.add(g.center(far) + test::uniformPoint<Dim>(random, 0.049));
    SuperRayGrouper<Dim> grouper;
    const auto supers = grouper.group(scan, 20);
    EXPECT_LT(supers.size(), Dim == 2 ? 40u : 400u);
    EXPECT_GT(supers.size(), 1u);
    // Fewer than k points in a cell: left alone.
    EXPECT_EQ(grouper.group(scan, 2001).size(), 2000u);
}

TYPED_TEST(SuperRays, RaysNearABorderStayAlone) {
    constexpr int Dim = TypeParam::value;
    const CellGeometry<Dim> g(1.0);
    Point<Dim> origin = Point<Dim>::Constant(0.5);
    RayBundle<Dim> scan(g, origin);
    Point<Dim> corner = Point<Dim>::Constant(0.5);  // straight over a grid point
    corner[0] = 4.5;
    corner[1] = 4.5;
    const int n = 30;
    for (int i = 0; i < n; ++i) {
        Point<Dim> p = corner;
        p[0] += 1e-9 * i;
        scan.add(p);
    }
    SuperRayGrouper<Dim> grouper;
    EXPECT_EQ(grouper.group(scan, 2).size(), static_cast<std::size_t>(n));
}

TYPED_TEST(SuperRays, OpenRaysAndHitsDoNotMix) {
    constexpr int Dim = TypeParam::value;
    const CellGeometry<Dim> g(1.0);
    RayBundle<Dim> scan(g, Point<Dim>::Constant(0.3));
    Point<Dim> end = Point<Dim>::Constant(0.4);
    end[0] = 9.3;
    for (int i = 0; i < 40; ++i) scan.add(end, i % 4 == 0 ? RayEnd::noReturn : RayEnd::hit);
    SuperRayGrouper<Dim> grouper;
    const auto& supers = grouper.group(scan, 2);
    ASSERT_EQ(supers.size(), 2u);
    EXPECT_EQ(supers[0].weight, 10u);
    EXPECT_EQ(supers[1].weight, 30u);
}

TYPED_TEST(SuperRays, RaysWithOwnOriginsStayAlone) {
    constexpr int Dim = TypeParam::value;
    const CellGeometry<Dim> g(1.0);
    RayBundle<Dim> scan(g, Point<Dim>::Constant(0.3));
    for (int i = 0; i < 40; ++i)
        scan.add(Point<Dim>::Constant(0.3 + 0.001 * i), Point<Dim>::Constant(5), RayEnd::hit);
    SuperRayGrouper<Dim> grouper;
    EXPECT_EQ(grouper.group(scan, 1).size(), 40u);
}

}  // namespace
}  // namespace superray
