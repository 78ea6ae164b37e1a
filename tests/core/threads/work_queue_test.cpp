// SPDX-License-Identifier: BSD-3-Clause
// A list that its owner works off in pieces, with the help of idle threads.

#include "threads/work_queue.h"

#include <gtest/gtest.h>

#include <optional>
#include <stdexcept>
#include <thread>
#include <vector>

namespace superray {
namespace {

TEST(WorkQueue, IsTakenInPiecesEachThingOnce) {
    WorkQueue queue;
    EXPECT_FALSE(queue.take());
    for (std::size_t size : {0u, 1u, 512u, 5000u}) {
        queue.publish(size);
        std::size_t next = 0;
        while (const auto piece = queue.take()) {
            EXPECT_EQ(piece->begin, next);
            EXPECT_GT(piece->end, piece->begin);
            next = piece->end;
        }
        EXPECT_EQ(next, size);
    }
}

TEST(WorkQueue, OwnerAndHelpersDoEachThingOnce) {
    constexpr std::size_t kSize = 150000, kHelpers = 2;
    WorkQueue queue;
    std::vector<std::uint32_t> things;  // the owner writes them before it publishes
    std::vector<std::atomic<int>> done(kSize);
    const auto work = [&](WorkPiece piece) {
        for (std::size_t i = piece.begin; i < piece.end; ++i) ++done[things[i]];
    };
    std::optional<WorkQueue::Round> round(queue);
    std::vector<std::thread> helpers;
    for (std::size_t h = 0; h < kHelpers; ++h) helpers.emplace_back([&] { queue.help(work); });
    for (std::uint32_t i = 0; i < kSize; ++i) things.push_back(i);
    queue.publish(things.size());
    while (const auto piece = queue.take()) work(*piece);
    round.reset();
    for (std::thread& t : helpers) t.join();
    for (const auto& n : done) ASSERT_EQ(n, 1);
}

TEST(WorkQueue, HelpersReturnWhenTheOwnerFails) {
    WorkQueue queue;
    std::thread helper;
    try {
        const WorkQueue::Round round(queue);
        helper = std::thread([&] { queue.help([](WorkPiece) {}); });
        throw std::runtime_error("the owner fails");
    } catch (const std::runtime_error&) {
    }
    helper.join();
    EXPECT_FALSE(queue.take());
}

TEST(WorkQueue, HelpersDoNothingForAnOwnerThatHasNotBegun) {
    WorkQueue queue;
    queue.publish(5000);  // what an owner that failed has left
    std::size_t done = 0;
    const auto count = [&](WorkPiece piece) { done += piece.end - piece.begin; };
    queue.help(count);
    EXPECT_EQ(done, 0u);
    {
        const WorkQueue::Round round(queue);
        queue.publish(0);
    }
    queue.help(count);
    EXPECT_EQ(done, 0u);
}

}  // namespace
}  // namespace superray
