// SPDX-License-Identifier: BSD-3-Clause
// Chunks of a scan that are equal work.

#include "threads/load_balancer.h"

#include <gtest/gtest.h>

#include <random>

namespace superray {
namespace {

/// Work of each chunk, if thing i of n is work(i / n).
template <typename Work>
std::vector<double> workOf(const LoadBalancer& balance, std::size_t chunks, std::size_t n,
                           const Work& work) {
    std::vector<double> sums(chunks);
    for (std::size_t s = 0; s < chunks; ++s)
        for (std::size_t i = balance.first(n, s); i < balance.first(n, s + 1); ++i)
            sums[s] += work(static_cast<double>(i) / static_cast<double>(n));
    return sums;
}

TEST(LoadBalancer, BeginsWithEqualShares) {
    LoadBalancer balance;
    for (const std::size_t chunks : {1u, 2u, 3u, 7u}) {
        balance.begin(chunks);
        for (const std::size_t n : {0u, 1u, 6u, 1000u}) {
            EXPECT_EQ(balance.first(n, 0), 0u);
            EXPECT_EQ(balance.first(n, chunks), n);
            for (std::size_t s = 0; s < chunks; ++s) {
                const std::size_t size = balance.first(n, s + 1) - balance.first(n, s);
                EXPECT_LE(size, n / chunks + 1);
                EXPECT_GE(size + 1, n / chunks);
            }
        }
        balance.learn(std::vector<double>(chunks, 7.0));
        EXPECT_EQ(balance.first(1000, 1), (1000 + chunks / 2) / chunks);
    }
}

TEST(LoadBalancer, SoonGivesEachTheSameWork) {
    constexpr std::size_t kThings = 100000;
    const auto density = [](double x) { return 1 + 20 * x * x + (x < 0.1 ? 15 : 0); };
    for (const std::size_t chunks : {2u, 3u, 5u}) {
        LoadBalancer balance;
        balance.begin(chunks);
        const auto most = [&] {
            const auto work = workOf(balance, chunks, kThings, density);
            double sum = 0, greatest = 0;
            for (const double w : work) {
                sum += w;
                greatest = std::max(greatest, w);
            }
            return greatest * static_cast<double>(chunks) / sum;
        };
        EXPECT_GT(most(), 1.3);
        for (int scan = 0; scan < 10; ++scan) {
            balance.begin(chunks);
            balance.learn(workOf(balance, chunks, kThings, density));
        }
        EXPECT_LT(most(), 1.05) << chunks;
    }
}

TEST(LoadBalancer, ChunkStayInOrderWhateverIsLearnt) {
    std::mt19937 random(7);
    std::size_t learnt = 0;
    for (const std::size_t chunks : {1u, 2u, 4u}) {
        LoadBalancer balance;
        balance.begin(chunks);
        for (int scan = 0; scan < 500; ++scan, ++learnt) {
            std::vector<double> work(chunks);
            for (double& w : work)
                w = random() % 3 == 0 ? 0.0 : 1e6 * static_cast<double>(random() % 1000);
            balance.learn(work);
            ASSERT_EQ(balance.first(999, 0), 0u);
            ASSERT_EQ(balance.first(999, chunks), 999u);
            for (std::size_t s = 0; s < chunks; ++s)
                ASSERT_LE(balance.first(999, s), balance.first(999, s + 1));
        }
    }
    EXPECT_EQ(learnt, 1500u);
}

TEST(LoadBalancer, AnotherNumberOfChunkBeginsAnew) {
    LoadBalancer balance;
    balance.begin(2);
    balance.learn({3, 1});
    EXPECT_LT(balance.first(1000, 1), 400u);
    balance.begin(2);
    EXPECT_LT(balance.first(1000, 1), 400u);
    balance.begin(3);
    EXPECT_EQ(balance.first(1000, 1), 333u);
    balance.begin(2);
    EXPECT_EQ(balance.first(1000, 1), 500u);
}

}  // namespace
}  // namespace superray
