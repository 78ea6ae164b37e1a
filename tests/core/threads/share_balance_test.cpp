// Shares of a scan that are equal work.

#include "threads/share_balance.h"

#include <gtest/gtest.h>

#include <random>

namespace superray {
namespace {

/// Work of each share, if thing i of n is work(i / n).
template <typename Work>
std::vector<double> workOf(const ShareBalance& balance, std::size_t shares, std::size_t n,
                           const Work& work) {
    std::vector<double> sums(shares);
    for (std::size_t s = 0; s < shares; ++s)
        for (std::size_t i = balance.first(n, s); i < balance.first(n, s + 1); ++i)
            sums[s] += work(static_cast<double>(i) / static_cast<double>(n));
    return sums;
}

TEST(ShareBalance, BeginsWithEqualShares) {
    ShareBalance balance;
    for (const std::size_t shares : {1u, 2u, 3u, 7u}) {
        balance.begin(shares);
        for (const std::size_t n : {0u, 1u, 6u, 1000u}) {
            EXPECT_EQ(balance.first(n, 0), 0u);
            EXPECT_EQ(balance.first(n, shares), n);
            for (std::size_t s = 0; s < shares; ++s) {
                const std::size_t size = balance.first(n, s + 1) - balance.first(n, s);
                EXPECT_LE(size, n / shares + 1);
                EXPECT_GE(size + 1, n / shares);
            }
        }
        balance.learn(std::vector<double>(shares, 7.0));
        EXPECT_EQ(balance.first(1000, 1), (1000 + shares / 2) / shares);
    }
}

TEST(ShareBalance, SoonGivesEachTheSameWork) {
    constexpr std::size_t kThings = 100000;
    const auto density = [](double x) { return 1 + 20 * x * x + (x < 0.1 ? 15 : 0); };
    for (const std::size_t shares : {2u, 3u, 5u}) {
        ShareBalance balance;
        balance.begin(shares);
        const auto most = [&] {
            const auto work = workOf(balance, shares, kThings, density);
            double sum = 0, greatest = 0;
            for (const double w : work) {
                sum += w;
                greatest = std::max(greatest, w);
            }
            return greatest * static_cast<double>(shares) / sum;
        };
        EXPECT_GT(most(), 1.3);
        for (int scan = 0; scan < 10; ++scan) {
            balance.begin(shares);
            balance.learn(workOf(balance, shares, kThings, density));
        }
        EXPECT_LT(most(), 1.05) << shares;
    }
}

TEST(ShareBalance, SharesStayInOrderWhateverIsLearnt) {
    std::mt19937 random(7);
    std::size_t learnt = 0;
    for (const std::size_t shares : {1u, 2u, 4u}) {
        ShareBalance balance;
        balance.begin(shares);
        for (int scan = 0; scan < 500; ++scan, ++learnt) {
            std::vector<double> work(shares);
            for (double& w : work)
                w = random() % 3 == 0 ? 0.0 : 1e6 * static_cast<double>(random() % 1000);
            balance.learn(work);
            ASSERT_EQ(balance.first(999, 0), 0u);
            ASSERT_EQ(balance.first(999, shares), 999u);
            for (std::size_t s = 0; s < shares; ++s)
                ASSERT_LE(balance.first(999, s), balance.first(999, s + 1));
        }
    }
    EXPECT_EQ(learnt, 1500u);
}

TEST(ShareBalance, AnotherNumberOfSharesBeginsAnew) {
    ShareBalance balance;
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
