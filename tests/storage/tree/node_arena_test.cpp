// SPDX-License-Identifier: BSD-3-Clause
// Memory of tree nodes: apart, side by side, used again, and not more than needed.

#include "tree/node_arena.h"

#include <gtest/gtest.h>

#include <cstring>
#include <deque>
#include <new>
#include <random>
#include <set>
#include <thread>

#include "core/memory/resident_memory.h"
#include "failing_allocations.h"

namespace superray::test {
namespace {

constexpr std::size_t kNode = NodeArena::kNodeBytes, kFamily = NodeArena::kFamilyBytes;

/// Fills what it takes with a pattern and checks that nobody else wrote there.
class Takings {
 public:
    explicit Takings(unsigned seed) : random_(seed) {}

    void step(NodeArena::Share& share) {
        share.reserve(kFamily);
        const auto kind = random_() % 2;
        auto& taken = taken_[kind];
        if (random_() % 3 != 0 || taken.empty()) {
            void* const p = kind ? share.family() : share.node();
            std::memset(p, pattern(p), kind ? kFamily : kNode);
            taken.push_back(p);
            ++made_;
        } else {
            std::swap(taken[random_() % taken.size()], taken.back());
            check(taken.back(), kind ? kFamily : kNode);
            kind ? share.releaseFamily(taken.back()) : share.releaseNode(taken.back());
            taken.pop_back();
        }
    }
    void checkAll() const {
        for (void* p : taken_[0]) check(p, kNode);
        for (void* p : taken_[1]) check(p, kFamily);
    }
    std::size_t bytes() const { return taken_[0].size() * kNode + taken_[1].size() * kFamily; }
    std::size_t made() const { return made_; }

 private:
    static unsigned char pattern(const void* p) {
        return static_cast<unsigned char>(reinterpret_cast<std::uintptr_t>(p) / kNode * 31);
    }
    static void check(const void* p, std::size_t bytes) {
        const auto* const b = static_cast<const unsigned char*>(p);
        for (std::size_t i = 0; i < bytes; ++i) ASSERT_EQ(b[i], pattern(p));
    }
    std::mt19937 random_;
    std::vector<void*> taken_[2];
    std::size_t made_ = 0;
};

TEST(NodeArena, NothingOverlaps) {
    NodeArena arena;
    Takings takings(5);
    for (int round = 0; round < 50; ++round) {
        NodeArena::Share share(arena);
        for (int i = 0; i < 4000; ++i) takings.step(share);
        takings.checkAll();
    }
    EXPECT_GT(takings.made(), 100000u);
    EXPECT_GT(takings.bytes(), 1000000u);
}

TEST(NodeArena, ReservedMemoryIsUsedBeforeOther) {
    constexpr std::size_t kReserved = 6 * NodeArena::kLastChunk;
    NodeArena arena;
    arena.reserve(kReserved + 5);
    EXPECT_EQ(arena.reservedBytes(), kReserved);
    EXPECT_EQ(arena.chunkBytes(), kReserved);
    arena.reserve(kReserved);
    EXPECT_EQ(arena.chunkBytes(), kReserved) << "that much is at hand already";
    Takings takings(8);
    {
        NodeArena::Share one(arena), other(arena);
        while (takings.bytes() < kReserved / 2) {
#ifdef __linux__
            one.reserve(kFamily);
            void* const family = one.family();
            // The page that it begins in.
            const auto address = reinterpret_cast<std::uintptr_t>(family) / 4096 * 4096;
            ASSERT_EQ(pagesOf(reinterpret_cast<void*>(address), 4096).resident, 4096u);
            one.releaseFamily(family);
#endif
            for (int i = 0; i < 1000; ++i) takings.step(i % 2 == 0 ? one : other);
        }
        takings.checkAll();
    }
    EXPECT_EQ(arena.chunkBytes(), kReserved);
    EXPECT_LT(arena.reservedBytes(), kReserved / 2);
    arena.clear();
    EXPECT_EQ(arena.reservedBytes(), 0u);
    EXPECT_EQ(arena.chunkBytes(), 0u);
}

TEST(NodeArena, SharesOfSeveralThreadsDoNotOverlap) {
    NodeArena arena;
    std::vector<Takings> takings;
    for (unsigned t = 0; t < 4; ++t) takings.emplace_back(t + 1);
    for (int round = 0; round < 8; ++round) {
        std::vector<std::thread> threads;
        for (Takings& mine : takings)
            threads.emplace_back([&] {
                NodeArena::Share share(arena);
                for (int i = 0; i < 10000; ++i) mine.step(share);
            });
        for (auto& t : threads) t.join();
        for (const Takings& t : takings) t.checkAll();
    }
    for (const Takings& t : takings) EXPECT_GT(t.made(), 50000u);
}

TEST(NodeArena, NodesMadeInTurnLieSideBySide) {
    NodeArena arena;
    NodeArena::Share share(arena);
    share.reserve(kFamily + 8 * kNode);
    const auto* const family = static_cast<std::byte*>(share.family());
    EXPECT_EQ(share.nodesInARow(5), family + kFamily);
    EXPECT_EQ(share.node(), family + kFamily + 5 * kNode);
    void* const released = share.node();
    share.releaseNode(released);
    EXPECT_EQ(share.nodesInARow(2), nullptr) << "there is a node to be used again";
    EXPECT_EQ(share.node(), released);
}

TEST(NodeArena, ChunksGrowWithTheArena) {
    NodeArena arena;
    NodeArena::Share share(arena);
    std::set<std::size_t> sizes;
    std::size_t used = 0, chunks = 0;
    for (; used < std::size_t{16} << 20; used += kNode) {
        const std::size_t before = arena.chunkBytes();
        share.reserve(kNode);
        share.node();
        if (const std::size_t fresh = arena.chunkBytes() - before; fresh > 0) {
            sizes.insert(fresh);
            ++chunks;
        }
        ASSERT_LE(arena.chunkBytes(), 2 * used + NodeArena::kFirstChunk);
    }
    EXPECT_EQ(*sizes.begin(), NodeArena::kFirstChunk);
    EXPECT_EQ(*sizes.rbegin(), NodeArena::kLastChunk);
    EXPECT_EQ(sizes.size(), 6u) << "64 KiB, 128 KiB, ... 2 MiB";
    EXPECT_LT(chunks, 16u);
}

TEST(NodeArena, ReservedMemoryIsThere) {
    NodeArena arena;
    std::size_t largest = 0;
    std::mt19937 random(9);
    for (int round = 0; round < 300; ++round) {
        NodeArena::Share share(arena);
        const std::size_t bytes = kNode * (1 + random() % 20000);
        share.reserve(bytes);
        largest = std::max(largest, bytes);
        const std::size_t before = arena.chunkBytes();
        for (std::size_t left = bytes; left > 0;) {
            const bool family = left >= kFamily && random() % 2;
            ASSERT_NE(family ? share.family() : share.node(), nullptr);
            left -= family ? kFamily : kNode;
        }
        ASSERT_EQ(arena.chunkBytes(), before);
    }
    EXPECT_GT(largest, NodeArena::kFirstChunk);
}

TEST(NodeArena, ReleasedMemoryIsUsedAgainByAnyShare) {
    NodeArena arena;
    std::size_t bytes = 0;
    for (int round = 0; round < 20; ++round) {
        std::vector<void*> nodes, families;
        {
            NodeArena::Share maker(arena);
            for (int i = 0; i < 20000; ++i) {
                maker.reserve(kNode + kFamily);
                nodes.push_back(maker.node());
                families.push_back(maker.family());
            }
        }
        NodeArena::Share other(arena);
        for (void* p : nodes) other.releaseNode(p);
        for (void* p : families) other.releaseFamily(p);
        if (round == 0) bytes = arena.chunkBytes();
        ASSERT_LE(arena.chunkBytes(), bytes + NodeArena::kLastChunk) << "round " << round;
    }
}

TEST(NodeArena, WhatSharesLeaveIsUsedUp) {
    NodeArena arena;
    for (int scan = 0; scan < 5000; ++scan) {
        NodeArena::Share share(arena);
        share.reserve(17000);  // much more than is used
        for (int i = 0; i < 10; ++i) share.node();
    }
    const std::size_t used = 5000u * 10 * kNode;
    EXPECT_LE(arena.chunkBytes(), 2 * used + NodeArena::kFirstChunk);
}

TEST(NodeArena, RoomIsTakenBeforehandAndCountedWhenItIsUsed) {
    std::mt19937 random(5);
    NodeArena arena;
    for (const unsigned shares : {1u, 3u, 1u}) {
        constexpr std::size_t kStep = 16000, kSteps = 400;
        constexpr std::size_t kNodes = kStep / 2 / kNode, kFamilies = kStep / 2 / kFamily;
        const NodeArena::Demand demand{kSteps * kNodes, kSteps * kFamilies, kStep, shares};
        const std::size_t before = arena.chunkBytes(), most = arena.chunkBytesAtMost(demand);
        arena.keepRoom(demand);
        EXPECT_EQ(arena.chunkBytes(), before);
        EXPECT_EQ(arena.chunkBytesAtMost(demand), most);
        {
            std::deque<NodeArena::Share> users;
            for (unsigned s = 0; s < shares; ++s) users.emplace_back(arena);
            allocations.allowed = 0;
            for (std::size_t step = 0; step < kSteps; ++step) {
                NodeArena::Share& user = users[random() % shares];
                user.reserve(kStep);
                for (std::size_t i = 0; i < kNodes; ++i) std::memset(user.node(), 1, kNode);
                for (std::size_t i = 0; i < kFamilies; ++i)
                    std::memset(user.family(), 2, kFamily);
            }
            allocations.allowed = -1;
        }
        EXPECT_LE(arena.chunkBytes(), most);
        EXPECT_GT(arena.chunkBytes(), before);
    }
}

TEST(NodeArena, RoomThatCannotBeHadTakesNothing) {
    constexpr std::size_t kStep = 16000;
    const NodeArena::Demand demand{1000000, 100000, kStep};
    for (int allowed = 0; allowed < 12; ++allowed) {
        NodeArena arena;
        const std::size_t freed = allocations.freed;
        const int asked = allocations.asked;
        allocations.allowed = allowed;
        EXPECT_THROW(arena.keepRoom(demand), std::bad_alloc);
        allocations.allowed = -1;
        // Other than what lists are made of: the chunks that there was memory for.
        EXPECT_EQ(arena.chunkBytes(), 0u);
        EXPECT_EQ(allocations.asked - asked, allowed + 1);
        EXPECT_GE(allocations.freed - freed + 1, static_cast<std::size_t>(allowed))
            << "all but a list's memory";
    }
}

TEST(NodeArena, SwapAndClear) {
    NodeArena a, b;
    {
        NodeArena::Share share(a);
        share.reserve(kNode);
        share.node();
    }
    a.swap(b);
    EXPECT_EQ(a.chunkBytes(), 0u);
    EXPECT_EQ(b.chunkBytes(), NodeArena::kFirstChunk);
    b.clear();
    EXPECT_EQ(b.chunkBytes(), 0u);
    NodeArena::Share share(b);
    share.reserve(kNode);
    EXPECT_NE(share.node(), nullptr);
}

}  // namespace
}  // namespace superray::test
