// SPDX-License-Identifier: BSD-3-Clause
// The order of blocks in a tree, against bit by bit.

#include "tree/block_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/dims.h"

namespace superray::test {
namespace {

template <int Dim>
std::uint64_t slowMortonOf(const BlockKey<Dim>& key) {
    std::uint64_t m = 0;
    for (int bit = 0; bit < kBlockDepth; ++bit)
        for (int a = 0; a < Dim; ++a) {
            const auto k = static_cast<std::uint64_t>(key[a] + (1 << (kBlockDepth - 1)));
            m |= ((k >> bit) & 1) << (Dim * bit + a);
        }
    return m;
}

template <typename T>
class BlockOrder : public ::testing::Test {};
TYPED_TEST_SUITE(BlockOrder, Dims);

TYPED_TEST(BlockOrder, MortonIsInterleavedBitsAndHasAnInverse) {
    constexpr int Dim = TypeParam::value;
    constexpr std::int32_t limit = 1 << (kBlockDepth - 1);
    std::mt19937 random(3);
    std::uniform_int_distribution<std::int32_t> anywhere(-limit, limit - 1);
    int keys = 0;
    for (; keys < 20000; ++keys) {
        BlockKey<Dim> key;
        for (auto& k : key)
            k = keys % 7 == 0 ? (random() % 2 ? limit - 1 : -limit) : anywhere(random);
        const std::uint64_t morton = mortonOf<Dim>(key);
        ASSERT_EQ(morton, slowMortonOf<Dim>(key));
        ASSERT_EQ(blockOfMorton<Dim>(morton), key);
    }
    EXPECT_EQ(keys, 20000);
}

TYPED_TEST(BlockOrder, SortingSorts) {
    constexpr int Dim = TypeParam::value;
    std::mt19937 random(4);
    std::vector<OrderedBlock> scratch;
    std::size_t sorted = 0;
    for (const std::size_t n : {0u, 1u, 2u, 100u, 5000u})
        for (const int spread : {1, 3, 100, 8192}) {
            std::vector<OrderedBlock> blocks(n);
            for (std::size_t i = 0; i < n; ++i) {
                BlockKey<Dim> key;
                for (auto& k : key)
                    k = static_cast<std::int32_t>(random() % unsigned(spread)) - spread / 2;
                blocks[i] = {mortonOf<Dim>(key), static_cast<std::uint32_t>(i), 0};
            }
            auto expected = blocks;
            std::stable_sort(expected.begin(), expected.end(),
                             [](const auto& a, const auto& b) { return a.morton < b.morton; });
            sortBlocks(blocks, scratch);
            ASSERT_EQ(blocks.size(), n);
            for (std::size_t i = 0; i < n; ++i, ++sorted) {
                ASSERT_EQ(blocks[i].morton, expected[i].morton);
                ASSERT_EQ(blocks[i].number, expected[i].number);
            }
        }
    EXPECT_EQ(sorted, 4u * 5103u);
}

}  // namespace
}  // namespace superray::test
