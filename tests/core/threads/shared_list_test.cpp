// A list that its owner works off, helped by others.

#include "threads/shared_list.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace superray {
namespace {

TEST(SharedList, IsTakenInPiecesEachThingOnce) {
    SharedList list;
    EXPECT_FALSE(list.take());
    for (std::size_t size : {0u, 1u, 512u, 5000u}) {
        list.publish(size);
        std::size_t next = 0;
        while (const auto piece = list.take()) {
            EXPECT_EQ(piece->begin, next);
            EXPECT_GT(piece->end, piece->begin);
            next = piece->end;
        }
        EXPECT_EQ(next, size);
    }
}

TEST(SharedList, OwnerAndHelpersDoEachThingOnce) {
    constexpr std::size_t kSize = 150000, kHelpers = 2;
    SharedList list;
    std::vector<std::uint32_t> things;  // the owner writes them before it publishes
    std::vector<std::atomic<int>> done(kSize);
    const auto work = [&](ListPiece piece) {
        for (std::size_t i = piece.begin; i < piece.end; ++i) ++done[things[i]];
    };
    list.open();
    std::vector<std::thread> helpers;
    for (std::size_t h = 0; h < kHelpers; ++h) helpers.emplace_back([&] { list.help(work); });
    for (std::uint32_t i = 0; i < kSize; ++i) things.push_back(i);
    list.publish(things.size());
    while (const auto piece = list.take()) work(*piece);
    list.close();
    for (std::thread& t : helpers) t.join();
    for (const auto& n : done) ASSERT_EQ(n, 1);
}

TEST(SharedList, HelpersReturnWhenTheOwnerFails) {
    SharedList list;
    list.open();
    std::thread helper([&] { list.help([](ListPiece) {}); });
    list.close();  // as its owner does, whatever happens
    helper.join();
    EXPECT_FALSE(list.take());
}

TEST(SharedList, HelpersDoNothingForAnOwnerThatHasNotBegun) {
    SharedList list;
    list.publish(5000);  // what an owner that failed has left
    std::size_t done = 0;
    const auto count = [&](ListPiece piece) { done += piece.end - piece.begin; };
    list.help(count);
    EXPECT_EQ(done, 0u);
    list.open();
    list.publish(0);
    list.close();
    list.help(count);
    EXPECT_EQ(done, 0u);
}

}  // namespace
}  // namespace superray
