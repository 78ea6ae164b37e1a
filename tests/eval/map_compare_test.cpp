// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <superray/eval/input_error.h>
#include <superray/eval/map_compare.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/storage/block_grid.h>

#include <random>

#include "eval/temp_folder.h"

namespace superray {
namespace {

using test::messageOf;
using test::TempFolder;

template <int Dim>
void compareSmallMaps() {
    BlockGrid<Dim> a{CellGeometry<Dim>(0.1)}, b{CellGeometry<Dim>(0.1)};
    const auto cell = [](int x) {
        Cell<Dim> c{};
        c[0] = x;
        return c;
    };
    for (int x = -20; x < 20; ++x) {
        a.setLogOdds(cell(x), 0.5f);
        b.setLogOdds(cell(x), 0.5f);
    }
    EXPECT_TRUE(compareMaps<Dim>(a, b).identical());
    a.setLogOdds(cell(100), 1);
    a.setLogOdds(cell(101), 1);
    b.setLogOdds(cell(-100), 1);
    b.setLogOdds(cell(3), 0.75f);
    b.setLogOdds(cell(4), -1.5f);
    b.setLogOdds(cell(5), std::nextafter(0.5f, 1.0f));
    auto d = compareMaps<Dim>(a, b);
    EXPECT_FALSE(d.identical());
    EXPECT_EQ(d.cellsA, 42u);
    EXPECT_EQ(d.cellsB, 41u);
    EXPECT_EQ(d.missing, 2u);
    EXPECT_EQ(d.extra, 1u);
    EXPECT_EQ(d.differing, 3u);
    EXPECT_EQ(d.largest, 2.0);
    d = compareMaps<Dim>(a, b, CellValues::occupancy);
    EXPECT_EQ(d.differing, 1u);
    d = compareMaps<Dim>(a, b, CellValues::occupancy, 0.6f, 0.6f);
    EXPECT_EQ(d.differing, 1u);  // now cell 3 alone
}

TEST(CompareMaps, countsWhatDiffersIn2D) {
    compareSmallMaps<2>();
}
TEST(CompareMaps, countsWhatDiffersIn3D) {
    compareSmallMaps<3>();
}

/// A map of seeded random rays.
template <class Map>
Map makeMap(unsigned seed, double resolution) {
    Map map(resolution);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> coordinate(-3, 3);
    RayBundle<3> rays(CellGeometry<3>(resolution), {0.01, 0.02, 0.03});
    for (int i = 0; i < 500; ++i) {
        const double x = coordinate(random), y = coordinate(random), z = coordinate(random);
        rays.add({x, y, z});
    }
    map.insertRays(rays);
    return map;
}

TEST(CompareMapFiles, findsExportsIdentical) {
    TempFolder folder;
    const auto grid = makeMap<CSuperRayGridMap3D>(1, 1.0 / 3);
    const auto tree = makeMap<CSuperRayOctoMap>(1, 1.0 / 3);
    grid.saveToFile(folder / "a.srmap");
    grid.exportOctomap(folder / "a.ot");
    grid.exportOctomap(folder / "a.bt");
    tree.saveToFile(folder / "b.srmap");
    tree.exportOctomap(folder / "b.ot");
    tree.exportOctomap(folder / "b.bt");
    const auto known = grid.cellTotals().known;
    ASSERT_GT(known, 500u);
    int pairs = 0;
    for (const char* a : {"a.srmap", "a.ot", "a.bt", "b.srmap", "b.ot", "b.bt"}) {
        for (const char* b : {"a.srmap", "a.ot", "a.bt", "b.srmap", "b.ot", "b.bt"}) {
            const auto d = compareMapFiles(folder / a, folder / b);
            EXPECT_TRUE(d.identical()) << a << " " << b << "\n" << describe(d);
            EXPECT_EQ(d.cellsA, known);
            EXPECT_EQ(d.cellsB, known);
            ++pairs;
        }
    }
    EXPECT_EQ(pairs, 36);
}

TEST(CompareMapFiles, findsDifferences) {
    TempFolder folder;
    makeMap<CSuperRayGridMap3D>(1, 0.25).saveToFile(folder / "a.srmap");
    makeMap<CSuperRayGridMap3D>(2, 0.25).saveToFile(folder / "b.srmap");
    const auto d = compareMapFiles(folder / "a.srmap", folder / "b.srmap");
    EXPECT_FALSE(d.identical());
    EXPECT_GT(d.differing, 0u);
    EXPECT_GT(d.largest, 0);
    EXPECT_NE(describe(d).find("different\n"), std::string::npos);
}

TEST(CompareMapFiles, refusesWhatCannotBeCompared) {
    TempFolder folder;
    makeMap<CSuperRayGridMap3D>(1, 0.25).saveToFile(folder / "a.srmap");
    makeMap<CSuperRayGridMap3D>(1, 0.5).saveToFile(folder / "b.srmap");
    CSuperRayGridMap2D(0.25).saveToFile(folder / "plan.srmap");
    const auto errorOf = [&](const char* a, const std::string& b) {
        return messageOf<std::runtime_error>([&] { compareMapFiles(folder / a, b); });
    };
    EXPECT_NE(errorOf("a.srmap", folder / "b.srmap").find("resolution"), std::string::npos);
    EXPECT_NE(errorOf("a.srmap", folder / "plan.srmap").find("dimensions"), std::string::npos);
    EXPECT_NE(errorOf("a.srmap", folder / "absent.srmap").find("absent.srmap"),
              std::string::npos);
    EXPECT_NE(errorOf("a.srmap", folder / "absent.ot").find("absent.ot"), std::string::npos);
    EXPECT_NE(errorOf("a.srmap", folder.write("c.xyz", "")).find("unknown kind"),
              std::string::npos);
    EXPECT_NE(errorOf("a.srmap", folder.write("c.srmap", "noise")), "no exception");
}

}  // namespace
}  // namespace superray
