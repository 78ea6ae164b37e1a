// SPDX-License-Identifier: BSD-3-Clause
// The digest depends on the contents of a map and on nothing else.

#include "storage/storage_test_tools.h"

#include <cmath>

namespace superray::test {
namespace {

template <int Dim, typename Tree>
void digestIsTheContents() {
    std::mt19937 random{7};
    const CellGeometry<Dim> geometry(0.1);
    BlockGrid<Dim> grid(geometry);
    Tree tree(geometry);
    const SensorModel model;
    for (int s = 0; s < 20; ++s) {
        const auto batch = randomBatch<Dim>(random, 12);
        grid.apply(batch, model, UpdatePolicy::everyRay);
        tree.apply(batch, model, UpdatePolicy::everyRay);
    }
    const std::string digest = contentDigest<Dim>(grid);
    EXPECT_EQ(digest.size(), 32u);
    EXPECT_EQ(digest.find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_EQ(digest, contentDigest<Dim>(tree));

    const Cells<Dim> cells = cellsOf<Dim>(grid);
    BlockGrid<Dim> reversed(geometry), coarser(CellGeometry<Dim>(0.1000001));
    for (auto it = cells.rbegin(); it != cells.rend(); ++it) {
        reversed.setLogOdds(it->first, it->second);
        coarser.setLogOdds(it->first, it->second);
    }
    EXPECT_EQ(digest, contentDigest<Dim>(reversed)) << "insertion order matters";
    EXPECT_NE(digest, contentDigest<Dim>(coarser)) << "resolution does not matter";

    // Any small change of one cell, or two values exchanged, shows.
    int changes = 0;
    for (auto it = cells.begin(); it != cells.end() && changes < 20; ++it, ++changes) {
        reversed.setLogOdds(it->first, std::nextafter(it->second, 100.0f));
        EXPECT_NE(digest, contentDigest<Dim>(reversed));
        reversed.setLogOdds(it->first, it->second);
    }
    EXPECT_EQ(changes, 20);
    EXPECT_EQ(digest, contentDigest<Dim>(reversed));
    const auto a = cells.begin();
    auto b = a;
    while (b->second == a->second) ++b;
    reversed.setLogOdds(a->first, b->second);
    reversed.setLogOdds(b->first, a->second);
    EXPECT_NE(digest, contentDigest<Dim>(reversed)) << "exchanged values";
}

TEST(ContentDigest, DependsOnContentsOnly2D) {
    digestIsTheContents<2, Quadtree>();
}
TEST(ContentDigest, DependsOnContentsOnly3D) {
    digestIsTheContents<3, Octree>();
}

TEST(ContentDigest, DimensionAndKnownZeroCellsMatter) {
    BlockGrid<2> flat{CellGeometry<2>(0.1)};
    BlockGrid<3> solid{CellGeometry<3>(0.1)};
    EXPECT_NE(contentDigest<2>(flat), contentDigest<3>(solid));
    const std::string empty = contentDigest<3>(solid);
    solid.setLogOdds({0, 0, 0}, 0.0f);
    EXPECT_NE(contentDigest<3>(solid), empty) << "a known cell of value 0 is not unknown";
}

}  // namespace
}  // namespace superray::test
