// SPDX-License-Identifier: BSD-3-Clause
// The culling region against its definition, cell by cell.

#include <superray/core/culling_region.h>
#include <superray/core/traversal.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <unordered_map>

#include "core/dims.h"
#include "core/ray_generators.h"

namespace superray {
namespace {

using test::Random;

template <int Dim>
using Blocks = std::unordered_map<BlockKey<Dim>, BlockMask<Dim>, IndexHash>;

template <typename T>
class CullingRegionOf : public ::testing::Test {};
TYPED_TEST_SUITE(CullingRegionOf, test::Dims);

TYPED_TEST(CullingRegionOf, EqualsItsDefinition) {
    constexpr int Dim = TypeParam::value;
    constexpr int kRadius = Dim == 2 ? 60 : 13;
    Random random(40);
    std::uint64_t cells = 0, inside = 0;
    for (int round = 0; round < 30; ++round) {
        Cell<Dim> sensor, lowest, highest;
        for (int a = 0; a < Dim; ++a) {
            sensor[a] = test::integer(random, -20, 20);
            lowest[a] = sensor[a] - kRadius;
            highest[a] = sensor[a] + kRadius;
        }
        // Whole blocks: the region is limited to the blocks of the extent.
        for (int a = 0; a < Dim; ++a) {
            lowest[a] &= ~(kBlockEdge - 1);
            highest[a] |= kBlockEdge - 1;
        }
        const double density = round % 3 == 0 ? 1.0 : test::uniform(random, 0.9, 0.999);
        Blocks<Dim> saturated;
        std::vector<Cell<Dim>> all;
        Cell<Dim> c = lowest;
        for (;;) {
            all.push_back(c);
            if (c == sensor ? round % 10 != 9 : test::uniform(random, 0, 1) < density)
                saturated[blockOf<Dim>(c)].set(indexInBlock<Dim>(c));
            int a = 0;
            while (a < Dim && c[a] == highest[a]) c[a] = lowest[a], ++a;
            if (a == Dim) break;
            ++c[a];
        }
        CullingRegion<Dim> region;
        region.build(sensor, lowest, highest,
                     [&](const BlockKey<Dim>& k) -> const BlockMask<Dim>* {
                         const auto it = saturated.find(k);
                         return it == saturated.end() ? nullptr : &it->second;
                     });
        // By definition, nearest cells first.
        const auto distance = [&](const Cell<Dim>& x) {
            int d = 0;
            for (int a = 0; a < Dim; ++a) d += std::abs(x[a] - sensor[a]);
            return d;
        };
        std::sort(all.begin(), all.end(), [&](const Cell<Dim>& x, const Cell<Dim>& y) {
            return distance(x) < distance(y);
        });
        std::unordered_map<Cell<Dim>, bool, IndexHash> expected;
        for (const Cell<Dim>& x : all) {
            bool enclosed = true;
            for (int a = 0; a < Dim && enclosed; ++a) {
                if (x[a] == sensor[a]) continue;
                Cell<Dim> nearer = x;
                nearer[a] += x[a] > sensor[a] ? -1 : 1;
                enclosed = expected[nearer];
            }
            const bool in = enclosed && saturated[blockOf<Dim>(x)].test(indexInBlock<Dim>(x));
            expected[x] = in;
            ASSERT_EQ(region.contains(x), in);
            const BlockMask<Dim>* mask = region.enclosed(blockOf<Dim>(x));
            // An empty region encloses nothing worth knowing.
            if (!region.empty()) {
                ASSERT_EQ(mask != nullptr && mask->test(indexInBlock<Dim>(x)), enclosed);
            }
            ++cells;
            inside += in;
        }
        Cell<Dim> outside = highest;
        ++outside[0];
        EXPECT_FALSE(region.contains(outside));

        // The first slice to walk, for any hint, by trying all slices.
        const CellGeometry<Dim> g(1.0);
        const Point<Dim> origin = g.center(sensor);
        int rays = 0;
        for (int i = 0; i < 100; ++i, ++rays) {
            const Point<Dim> end = origin + test::uniformPoint<Dim>(random, kRadius - 1);
            const RayLine<Dim> line(g, origin, end);
            std::int32_t slice = 0;
            for (std::int32_t k = 0; k < line.slices(); ++k) {
                Cell<Dim> entry;
                for (int a = 0; a < Dim; ++a) entry[a] = line.entryCell(a, k);
                if (region.contains(line.unmirrored(entry))) slice = k;
            }
            for (std::int32_t hint : {0, 1, 5, 12, 1000})
                ASSERT_EQ(region.firstSliceToWalk(line, hint), slice) << "hint " << hint;
        }
        EXPECT_EQ(rays, 100);
    }
    EXPECT_GT(cells, 30u * 15000);
    EXPECT_GT(inside, cells / 10);
    EXPECT_LT(inside, cells);
}

TYPED_TEST(CullingRegionOf, IsEmptyWhereTheSensorIsNotSaturated) {
    constexpr int Dim = TypeParam::value;
    BlockMask<Dim> full;
    for (auto& w : full.words) w = ~std::uint64_t{0};
    full.reset(0);
    CullingRegion<Dim> region;
    Cell<Dim> sensor{}, lowest, highest;
    lowest.fill(-8);
    highest.fill(15);
    region.build(sensor, lowest, highest, [&](const BlockKey<Dim>&) { return &full; });
    EXPECT_TRUE(region.empty());
    EXPECT_FALSE(region.contains(sensor));
}

}  // namespace
}  // namespace superray
