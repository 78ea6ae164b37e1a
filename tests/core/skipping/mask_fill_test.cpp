// SPDX-License-Identifier: BSD-3-Clause
// Sets of cells of a block against cell by cell searches.

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/dims.h"
#include "skipping/mask_fill.h"

namespace superray {
namespace {

template <typename T>
class MaskFill : public ::testing::Test {};
TYPED_TEST_SUITE(MaskFill, test::Dims);

template <int Dim>
BlockMask<Dim> randomMask(std::mt19937_64& random, double share) {
    BlockMask<Dim> mask;
    std::bernoulli_distribution in(share);
    for (int i = 0; i < kBlockCells<Dim>; ++i)
        if (in(random)) mask.set(i);
    return mask;
}

/// Calls visit(neighbour) for the cells of the block beside cell i.
template <int Dim, typename Visit>
void forEachNeighbour(int i, const Visit& visit) {
    const Cell<Dim> cell = cellInBlock<Dim>({}, i);
    for (int a = 0; a < Dim; ++a)
        for (int step : {-1, 1}) {
            Cell<Dim> n = cell;
            n[a] += step;
            if (n[a] >= 0 && n[a] < kBlockEdge) visit(indexInBlock<Dim>(n));
        }
}

template <int Dim>
BlockMask<Dim> searched(const BlockMask<Dim>& from, const BlockMask<Dim>& within) {
    BlockMask<Dim> found = from;
    std::vector<int> queue;
    for (int i = 0; i < kBlockCells<Dim>; ++i)
        if (from.test(i)) queue.push_back(i);
    while (!queue.empty()) {
        const int i = queue.back();
        queue.pop_back();
        forEachNeighbour<Dim>(i, [&](int n) {
            if (!within.test(n) || found.test(n)) return;
            found.set(n);
            queue.push_back(n);
        });
    }
    return found;
}

TYPED_TEST(MaskFill, FillsWhatIsConnected) {
    constexpr int Dim = TypeParam::value;
    std::mt19937_64 random(31);
    int partly = 0, masks = 0;
    for (double share : {0.3, 0.5, 0.6, 0.7, 0.9, 1.0}) {
        for (int repeat = 0; repeat < 200; ++repeat, ++masks) {
            const auto within = randomMask<Dim>(random, share);
            BlockMask<Dim> cells = randomMask<Dim>(random, 0.02);
            for (int w = 0; w < BlockMask<Dim>::kWords; ++w) cells.words[w] &= within.words[w];
            const auto expected = searched<Dim>(cells, within);
            if (share == 1.0 && !cells.any()) continue;  // fill() is asked with a cell
            partly += expected != within && expected != cells;
            fill<Dim>(cells, within);
            ASSERT_EQ(cells, expected);
        }
    }
    EXPECT_EQ(masks, 1200);
    EXPECT_GT(partly, 300);
}

TYPED_TEST(MaskFill, DilatesByFaces) {
    constexpr int Dim = TypeParam::value;
    for (int i = 0; i < kBlockCells<Dim>; ++i) {
        BlockMask<Dim> cell, expected;
        cell.set(i);
        forEachNeighbour<Dim>(i, [&](int n) { expected.set(n); });
        ASSERT_EQ(dilated<Dim>(cell), expected) << i;
    }
}

TYPED_TEST(MaskFill, CrossesFacesToTheCellsOpposite) {
    constexpr int Dim = TypeParam::value;
    int crossings = 0;
    for (int i = 0; i < kBlockCells<Dim>; ++i) {
        BlockMask<Dim> cell;
        cell.set(i);
        for (int a = 0; a < Dim; ++a)
            for (int step : {-1, 1}) {
                Cell<Dim> to = cellInBlock<Dim>({}, i);
                to[a] += step;
                BlockMask<Dim> expected;
                BlockKey<Dim> neighbour{};
                neighbour[a] = step;
                if (blockOf<Dim>(to) == neighbour) expected.set(indexInBlock<Dim>(to));
                crossings += expected.any();
                ASSERT_EQ(acrossFace<Dim>(cell, a, step), expected) << i << " " << a;
            }
    }
    EXPECT_EQ(crossings, 2 * Dim * kBlockCells<Dim - 1>);
}

}  // namespace
}  // namespace superray
