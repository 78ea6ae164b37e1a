// SPDX-License-Identifier: BSD-3-Clause
// Objects by number: none moves, none is another, and pools take little more than they need.

#include "containers/chunked_pool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "core/memory/resident_memory.h"
#include "failing_allocations.h"

namespace superray::test {
namespace {

struct alignas(64) Object {
    std::array<std::uint32_t, 64> words;
};
using Pool = ChunkedPool<Object, 64>;
constexpr std::uint32_t kMany = 50000;

void fill(Pool& pool, std::uint32_t count) {
    for (std::uint32_t n = 0; n < count; ++n) {
        const std::uint32_t i = pool.allocate();
        ASSERT_EQ(i, n);
        pool[i].words.fill(7 * n + 1);
    }
}

void expectFilled(const Pool& pool, std::uint32_t count) {
    for (std::uint32_t n = 0; n < count; ++n)
        for (const std::uint32_t word : pool[n].words) ASSERT_EQ(word, 7 * n + 1) << n;
}

TEST(ChunkedPool, ObjectsKeepTheirPlace) {
    Pool pool;
    std::vector<const Object*> places;
    for (std::uint32_t n = 0; n < kMany; ++n) {
        const std::uint32_t i = pool.allocate();
        places.push_back(&pool[i]);
        pool[i].words.fill(7 * n + 1);
        ASSERT_EQ(reinterpret_cast<std::uintptr_t>(&pool[i]) % alignof(Object), 0u);
    }
    for (std::uint32_t n = 0; n < kMany; ++n) ASSERT_EQ(&pool[n], places[n]);
    expectFilled(pool, kMany);
}

TEST(ChunkedPool, TakesLittleMoreThanItNeeds) {
    Pool pool;
    EXPECT_LT(pool.memoryBytes(), 100u);
    for (std::uint32_t n = 1; n <= kMany; ++n) {
        pool.allocate();
        const std::size_t used = n * sizeof(Object), taken = pool.memoryBytes();
        ASSERT_GE(taken, used);
        // A chunk, and pointers to all of them.
        ASSERT_LE(taken, used + 64 * sizeof(Object) + used / 100 + 100) << n;
    }
}

TEST(ChunkedPool, UsesReleasedNumbersAgain) {
    Pool pool;
    fill(pool, kMany);
    pool.release(5);
    pool.release(kMany - 1);
    EXPECT_EQ(pool.allocate(), kMany - 1);
    EXPECT_EQ(pool.allocate(), 5u);
    EXPECT_EQ(pool.allocate(), kMany);
}

TEST(ChunkedPool, ReservedMemoryIsTakenBeforehand) {
    for (const std::uint32_t count : {0u, 1000u}) {
        Pool pool;
        fill(pool, count);
        // So much comes from the system, not from what the process had and freed.
        constexpr std::size_t kReserved = std::size_t{48} << 20;
        pool.reserve(kReserved);
        const std::size_t taken = pool.memoryBytes();
        EXPECT_GE(taken, kReserved + count * sizeof(Object));
        pool.reserve(kReserved / 2);
        EXPECT_EQ(pool.memoryBytes(), taken) << "that much is at hand already";
#ifdef __linux__
        const Object* const first = &pool[(count + 63) / 64 * 64];
        const auto pages = pagesOf(first, kReserved);
        EXPECT_EQ(pages.resident, pages.bytes);
#endif
        const Pool copy(pool);
        expectFilled(copy, count);
        EXPECT_LT(copy.memoryBytes(), (count + 64) * sizeof(Object) * 11 / 10)
            << "only what is used is copied";
        std::uint32_t made = count;
        for (; made < count + kReserved / sizeof(Object); ++made) {
            ASSERT_EQ(pool.allocate(), made);
            pool[made].words.fill(7 * made + 1);
        }
        EXPECT_EQ(pool.memoryBytes(), taken);
        expectFilled(pool, made);
        expectFilled(Pool(pool), made);
    }
}

TEST(ChunkedPool, RoomIsTakenBeforehandAndCountedWhenItIsUsed) {
    for (const std::uint32_t count : {0u, 64u, 1000u}) {
        Pool pool;
        fill(pool, count);
        for (std::uint32_t n = 0; n < count; n += 7) pool.release(n);
        const std::size_t before = pool.memoryBytes();
        const std::size_t most = pool.memoryBytesAtMost(kMany);
        pool.keepRoom(kMany);
        EXPECT_EQ(pool.memoryBytes(), before);
        std::vector<const Object*> places(kMany);
        allocations.allowed = 0;
        for (const Object*& place : places) place = &pool[pool.allocate()];
        allocations.allowed = -1;
        EXPECT_LE(pool.memoryBytes(), most);
        EXPECT_GT(pool.memoryBytes(), kMany * sizeof(Object));
        std::sort(places.begin(), places.end());
        EXPECT_EQ(std::unique(places.begin(), places.end()), places.end());
        pool.reserve(1 << 20);
        EXPECT_GE(pool.memoryBytes(), (kMany * sizeof(Object)) + (1 << 20));
    }
}

TEST(ChunkedPool, CopiesAreIndependent) {
    for (const std::uint32_t count : {0u, 1u, 64u, 65u, kMany}) {
        Pool pool;
        fill(pool, count);
        Pool copy(pool);
        for (std::uint32_t n = 0; n < count; ++n) pool[n].words.fill(0);
        expectFilled(copy, count);
        EXPECT_EQ(copy.allocate(), count);
        EXPECT_EQ(pool.allocate(), count);

        Pool moved(std::move(copy));
        expectFilled(moved, count);
        moved.clear();
        fill(moved, 200);
        expectFilled(moved, 200);
        EXPECT_LT(moved.memoryBytes(), 2 * 200 * sizeof(Object));
    }
}

}  // namespace
}  // namespace superray::test
