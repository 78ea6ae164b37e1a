// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/block.h>
#include <superray/core/cell.h>

#include <gtest/gtest.h>

#include <limits>

namespace superray {
namespace {

TEST(CellGeometry, CellOfAPointIsAFloor) {
    const CellGeometry<3> g(0.1);
    EXPECT_EQ(g.cellOf({0.05, -0.05, 0.0}), (Cell<3>{0, -1, 0}));
    EXPECT_EQ(g.cellOf({0.1, -0.1, 12.34}), (Cell<3>{1, -1, 123}));
    const CellGeometry<2> h(0.25);
    EXPECT_EQ(h.cellOf({-0.25, -0.2500001}), (Cell<2>{-1, -2}));
}

TEST(CellGeometry, ResolutionMustBePositiveAndFinite) {
    for (double bad : {0.0, -0.1, std::numeric_limits<double>::quiet_NaN(),
                       std::numeric_limits<double>::infinity(), 1e-320}) {
        try {
            CellGeometry<3> g(bad);
            FAIL() << bad;
        } catch (const std::invalid_argument& e) {
            EXPECT_NE(std::string(e.what()).find("resolution"), std::string::npos);
        }
    }
}

TEST(CellGeometry, AddressableRange) {
    const CellGeometry<2> g(0.5);
    EXPECT_TRUE(g.contains({-16384.0, 16383.999}));
    EXPECT_FALSE(g.contains({-16384.001, 0}));
    EXPECT_FALSE(g.contains({0, 16384.0}));
    EXPECT_FALSE(g.contains({std::numeric_limits<double>::quiet_NaN(), 0}));
    EXPECT_FALSE(g.contains({0, -std::numeric_limits<double>::infinity()}));
}

TEST(CellGeometry, CentreAndCornerInvertCellOf) {
    const CellGeometry<3> g(0.07);
    int cells = 0;
    for (int i = -2000; i < 2000; i += 7, ++cells) {
        const Cell<3> c{i, -i, 3 * i};
        ASSERT_EQ(g.cellOf(g.center(c)), c);
        ASSERT_NEAR(g.lowerCorner(c)[2], 3 * i * 0.07, 1e-9);
    }
    EXPECT_EQ(cells, 572);
}

TEST(Block, CellAndBlockIndicesAreInverse) {
    int cells = 0;
    for (int x = -20; x < 20; ++x)
        for (int y = -9; y < 9; ++y)
            for (int z = -17; z < 17; ++z, ++cells) {
                const Cell<3> c{x, y, z};
                ASSERT_EQ(cellInBlock<3>(blockOf<3>(c), indexInBlock<3>(c)), c);
                const Cell<2> d{x, y};
                ASSERT_EQ(cellInBlock<2>(blockOf<2>(d), indexInBlock<2>(d)), d);
            }
    EXPECT_EQ(cells, 40 * 18 * 34);
    EXPECT_EQ(blockOf<2>({-1, 8}), (BlockKey<2>{-1, 1}));
    EXPECT_EQ(indexInBlock<3>({1, 2, 3}), 1 + 8 * 2 + 64 * 3);
}

TEST(BlockMask, BitsCountAnyAll) {
    BlockMask<3> m;
    EXPECT_FALSE(m.any());
    m.set(511);
    EXPECT_TRUE(m.test(511));
    EXPECT_TRUE(m.any());
    for (int i = 0; i < 512; ++i) m.set(i);
    EXPECT_TRUE(m.all());
    EXPECT_EQ(m.count(), 512);
    m.reset(64);
    EXPECT_FALSE(m.all());
    EXPECT_EQ(m.count(), 511);
}

}  // namespace
}  // namespace superray
