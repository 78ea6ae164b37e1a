// SPDX-License-Identifier: BSD-3-Clause
// Work shared out to threads.

#include <superray/core/detail/parallel.h>
#include <superray/core/processors.h>

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace superray {
namespace {

TEST(InParallel, DoesEachChunkOnce) {
    for (const std::size_t chunks : {1u, 2u, 5u, 1024u}) {
        std::vector<std::atomic<int>> done(chunks);
        inParallel(chunks, [&](std::size_t chunk) { ++done[chunk]; });
        for (const auto& n : done) ASSERT_EQ(n, 1);
    }
}

TEST(InParallel, TwoChunksCanMeet) {
    if (availableProcessors() < 2) GTEST_SKIP() << "one processor";
    // A chunk that the pool has not begun in time is done afterwards: it may happen that
    // two do not meet, but not always.
    int met = 0;
    for (int attempt = 0; attempt < 100 && met == 0; ++attempt) {
        std::atomic<int> here{0};
        std::atomic<bool> both{false};
        inParallel(2, [&](std::size_t) {
            if (++here == 2) both = true;
            for (int i = 0; i < 100000 && !both; ++i) std::this_thread::yield();
            --here;
        });
        met += both;
    }
    EXPECT_GT(met, 0);
}

TEST(InParallel, AllChunkEndBeforeTheFirstFailureIsThrown) {
    std::atomic<int> ended{0};
    const auto work = [&](std::size_t chunk) {
        ++ended;
        if (chunk >= 2) throw std::runtime_error("chunk " + std::to_string(chunk));
    };
    try {
        inParallel(8, work);
        FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& e) {
        EXPECT_STREQ(e.what(), "chunk 2");
    }
    EXPECT_EQ(ended, 8);
    EXPECT_THROW(inParallel(1, [](std::size_t) { throw std::runtime_error("it"); }),
                 std::runtime_error);
}

TEST(InParallel, SeveralThreadsMayCallIt) {
    constexpr std::size_t kCallers = 4, kCalls = 200, kChunks = 3;
    std::atomic<std::size_t> done{0};
    std::vector<std::thread> callers;
    for (std::size_t c = 0; c < kCallers; ++c)
        callers.emplace_back([&] {
            for (std::size_t i = 0; i < kCalls; ++i) {
                std::atomic<std::size_t> mine{0};
                inParallel(kChunks, [&](std::size_t) { ++mine; });
                done += mine == kChunks ? kChunks : 0;
            }
        });
    for (std::thread& t : callers) t.join();
    EXPECT_EQ(done, kCallers * kCalls * kChunks);
}

}  // namespace
}  // namespace superray
