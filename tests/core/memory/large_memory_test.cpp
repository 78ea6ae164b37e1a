// SPDX-License-Identifier: BSD-3-Clause
// Memory of large arrays: it keeps what it holds, and takes no more than is used.

#include <superray/core/detail/large_memory.h>

#include "memory/huge_page_supply.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <new>
#include <vector>

#include "core/memory/resident_memory.h"

namespace superray {
namespace {

std::byte patternAt(std::size_t i) {
    return static_cast<std::byte>(i * 2654435761u >> 13);
}

TEST(LargeMemory, KeepsItsContentsWhileItGrows) {
    LargeMemory memory;
    EXPECT_EQ(memory.size(), 0u);
    std::size_t written = 0, checked = 0;
    for (std::size_t bytes = 100; bytes < 20 * kHugePage; bytes *= 2) {
        memory.grow(bytes);
        ASSERT_GE(memory.size(), bytes);
        for (std::size_t i = 0; i < written; ++i, ++checked)
            ASSERT_EQ(memory.data()[i], patternAt(i)) << bytes;
        memory.expectWrites(memory.size());
        for (; written < memory.size(); ++written) memory.data()[written] = patternAt(written);
    }
    EXPECT_GT(checked, 6 * kHugePage);
    const std::byte* const data = memory.data();
    memory.grow(5);
    EXPECT_EQ(memory.data(), data) << "it never shrinks";
}

TEST(LargeMemory, FailureLeavesItAsItWas) {
    for (const std::size_t bytes : {std::size_t{1000}, 3 * kHugePage}) {
        LargeMemory memory(bytes);
        memory.expectWrites(bytes);
        memory.data()[999] = std::byte{42};
        const std::size_t size = memory.size();
        EXPECT_THROW(memory.grow(std::size_t{1} << 62), std::bad_alloc);
        EXPECT_EQ(memory.size(), size);
        EXPECT_EQ(memory.data()[999], std::byte{42});
    }
}

TEST(LargeMemory, MovesAndSwaps) {
    LargeMemory a(2 * kHugePage), b(7);
    const std::byte *const large = a.data(), *const small = b.data();
    a.swap(b);
    EXPECT_EQ(a.data(), small);
    EXPECT_EQ(b.data(), large);
    const LargeMemory c(std::move(b));
    EXPECT_EQ(c.data(), large);
    EXPECT_EQ(c.size(), 2 * kHugePage);
}

#ifdef __linux__
std::size_t residentBytes(const LargeMemory& memory) {
    return test::pagesOf(memory.data(), memory.size()).resident;
}

TEST(LargeMemory, WhatIsNotUsedTakesNoMemory) {
    LargeMemory memory(20 * kHugePage);
    EXPECT_EQ(residentBytes(memory), 0u);
    const std::size_t used = 3 * kHugePage;
    memory.expectWrites(used);
    std::fill_n(memory.data(), used, std::byte{1});
    EXPECT_EQ(residentBytes(memory), used);
    memory.grow(100 * kHugePage);
    EXPECT_EQ(residentBytes(memory), used) << "nothing is copied";
    EXPECT_EQ(memory.data()[used - 1], std::byte{1});
}

TEST(LargeMemory, LargeAreasBeginWithAHugePage) {
    LargeMemory memory(kHugePage);
    for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(memory.data()) % kHugePage, 0u);
        EXPECT_EQ(memory.size() % kHugePage, 0u);
        memory.grow(memory.size() + 1);
    }
}
#endif

TEST(HugePageSupply, PausesAfterASlowPageAndLongerAfterAnother) {
    using Clock = HugePageSupply::Clock;
    HugePageSupply supply;
    const Clock::duration slow = 3 * HugePageSupply::kSlow, fast = slow / 6;
    Clock::time_point now = Clock::now();
    const auto touch = [&](Clock::duration duration) {
        supply.noteTouch(now, now + duration);
        now += duration;
    };
    const auto expectPause = [&](Clock::duration pause) {
        EXPECT_FALSE(supply.hasPage(now));
        EXPECT_FALSE(supply.hasPage(now + pause - fast));
        EXPECT_TRUE(supply.hasPage(now += pause));
    };
    const Clock::duration first = HugePageSupply::kFirstPause;
    EXPECT_TRUE(supply.hasPage(now));
    touch(fast);
    EXPECT_TRUE(supply.hasPage(now));
    for (const int times : {1, 4, 16, 64, 64}) {
        touch(slow);
        expectPause(times * first);
    }
    for (int i = 0; i < 5; ++i) touch(fast);
    EXPECT_TRUE(supply.hasPage(now));
    touch(slow);
    expectPause(2 * first);
    for (int i = 0; i < 20; ++i) touch(fast);
    touch(slow);
    expectPause(first);
}

TEST(ZeroedBytes, AppendsZerosWhereOthersWere) {
    ZeroedBytes bytes;
    std::size_t checked = 0;
    for (int round = 0; round < 3; ++round) {
        while (bytes.size() < 3 * kHugePage) {
            const std::size_t before = bytes.size(), n = 1 + before / 3;
            bytes.append(n);
            ASSERT_EQ(bytes.size(), before + n);
            ASSERT_GE(bytes.capacity(), bytes.size() + ZeroedBytes::kSlack);
            for (std::size_t i = before; i < bytes.size(); ++i, ++checked) {
                ASSERT_EQ(bytes.data()[i], 0);
                bytes.data()[i] = 77;
            }
            ASSERT_EQ(bytes.data()[before / 2], 77);
        }
        const std::size_t capacity = bytes.capacity();
        bytes.shrink(static_cast<std::size_t>(round));
        EXPECT_EQ(bytes.capacity(), capacity) << "memory is kept";
    }
    EXPECT_GT(checked, 9 * kHugePage);
}

TEST(ZeroedBytes, CopiesAreIndependent) {
    for (const std::size_t n : {std::size_t{0}, std::size_t{10}, kHugePage + 10}) {
        ZeroedBytes a;
        a.append(n);
        std::fill_n(a.data(), n, std::uint8_t{3});
        ZeroedBytes b(a), c;
        c.append(1);
        c = a;
        std::fill_n(a.data(), n, std::uint8_t{4});
        ASSERT_EQ(b.size(), n);
        ASSERT_EQ(c.size(), n);
        EXPECT_EQ(std::count(b.data(), b.data() + n, 3), static_cast<std::ptrdiff_t>(n));
        EXPECT_EQ(std::count(c.data(), c.data() + n, 3), static_cast<std::ptrdiff_t>(n));
        const ZeroedBytes d(std::move(b));
        EXPECT_EQ(d.size(), n);
        EXPECT_EQ(std::count(d.data(), d.data() + n, 3), static_cast<std::ptrdiff_t>(n));
    }
}

}  // namespace
}  // namespace superray
