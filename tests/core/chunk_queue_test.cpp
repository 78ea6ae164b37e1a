// Chunks of work for several threads.

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "chunk_queue.h"

namespace superray {
namespace {

TEST(ChunkQueue, GivesEachChunkOnce) {
    for (std::size_t chunks : {0u, 1u, 7u, 1000u}) {
        constexpr std::size_t kThreads = 3;
        ChunkQueue queue(chunks, kThreads);
        std::vector<std::atomic<int>> taken(chunks);
        std::vector<std::thread> threads;
        for (std::size_t s = 0; s < kThreads; ++s)
            threads.emplace_back([&, s] {
                while (const auto c = queue.take(s)) ++taken.at(*c);
            });
        for (std::thread& t : threads) t.join();
        for (const auto& n : taken) EXPECT_EQ(n, 1);
        EXPECT_FALSE(queue.take(0));
    }
}

TEST(ChunkQueue, HelpsFromTheOtherEnd) {
    ChunkQueue queue(6, 2);
    EXPECT_EQ(queue.take(0), 0u);
    EXPECT_EQ(queue.take(1), 3u);
    EXPECT_EQ(queue.take(0), 1u);
    EXPECT_EQ(queue.take(0), 2u);
    EXPECT_EQ(queue.take(0), 5u);
    EXPECT_EQ(queue.take(1), 4u);
    EXPECT_EQ(queue.take(1), std::nullopt);
}

}  // namespace
}  // namespace superray
