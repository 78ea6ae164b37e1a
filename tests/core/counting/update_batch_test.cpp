// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/update_batch.h>

#include <gtest/gtest.h>

#include "core/memory/resident_memory.h"

namespace superray {
namespace {

TEST(UpdateBatch, LendsAndBorrowsBlocks) {
    constexpr int kCells = UpdateBatch<3>::kCells;
    UpdateBatch<3> lender, batch;
    const auto lent = lender.addBlock({1, 2, 3});
    lender.missesOf(lent)[7] = 9;
    lender.hitsOf(lent)[8] = 2;
    const auto plain = lender.addBlock({4, 5, 6});
    lender.missesOf(plain)[0] = 1;

    const auto own = batch.addBlock({-1, 0, 0});
    batch.missesOf(own)[kCells - 1] = 3;
    batch.borrowBlock(lender.key(lent), lender.misses(lent), lender.hits(lent));
    batch.borrowBlock(lender.key(plain), lender.misses(plain), lender.hits(plain));

    ASSERT_EQ(batch.blockCount(), 3u);
    EXPECT_EQ(batch.key(1), (BlockKey<3>{1, 2, 3}));
    EXPECT_EQ(batch.misses(0)[kCells - 1], 3);
    EXPECT_EQ(batch.hits(0), nullptr);
    EXPECT_EQ(batch.misses(1)[7], 9);
    ASSERT_NE(batch.hits(1), nullptr);
    EXPECT_EQ(batch.hits(1)[8], 2);
    EXPECT_EQ(batch.hits(2), nullptr);
    EXPECT_EQ(batch.touched(1).count(), 2);
    EXPECT_EQ(batch.touched(2).count(), 1);

    batch.clear();
    EXPECT_EQ(batch.blockCount(), 0u);
    const auto again = batch.addBlock({7, 7, 7});
    EXPECT_EQ(again, 0u);
    EXPECT_FALSE(batch.touched(again).any());
}

TEST(UpdateBatch, ReservedMemoryIsUsedBeforeOther) {
    constexpr std::size_t kReserved = 8u << 20;
    UpdateBatch<3> batch;
    batch.missesOf(batch.addBlock({1, 2, 3}))[7] = 9;
    batch.reserve(kReserved);
    EXPECT_EQ(batch.blockCount(), 0u) << "what was there is forgotten";
    const std::size_t reserved = batch.memoryBytes();
    EXPECT_GE(reserved, kReserved * 9 / 10);
#ifdef __linux__
    const auto pages = test::pagesOf(batch.missArena(), kReserved * 3 / 4);
    EXPECT_EQ(pages.resident, pages.bytes);
#endif
    std::uint32_t blocks = 0;
    for (; blocks < kReserved / 1024; ++blocks) {
        const BlockKey<3> key{static_cast<std::int32_t>(blocks), 0, 0};
        ASSERT_EQ(batch.addBlock(key), blocks);
        ASSERT_FALSE(batch.touched(blocks).any());
        batch.missesOf(blocks)[blocks % 512] = 255;
    }
    EXPECT_EQ(batch.memoryBytes(), reserved);
}

}  // namespace
}  // namespace superray
