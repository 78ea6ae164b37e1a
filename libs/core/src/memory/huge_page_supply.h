// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// When to ask the system for huge pages.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>

namespace superray {

/// A system may have no huge page at hand: it moves other memory out of the way
/// first, or the host of a virtual machine must provide what the guest had given
/// back. That takes milliseconds, more than all the small pages would. Then small
/// ones are used for a while, and for longer each time it happens again.
class HugePageSupply {
 public:
    using Clock = std::chrono::steady_clock;
    /// The 512 small pages take 0.1 to 0.8 ms, a huge one at hand 0.05 to 0.2 ms.
    static constexpr std::chrono::milliseconds kSlow{1};
    /// Even where it happens every time, little is lost.
    static constexpr std::chrono::seconds kFirstPause{10}, kLongestPause{640};

    bool hasPage(Clock::time_point now) const {
        return now.time_since_epoch().count() >= notBefore_.load(std::memory_order_relaxed);
    }
    /// Notes when the first touch of a huge page began and ended.
    void noteTouch(Clock::time_point begin, Clock::time_point end) {
        const Clock::rep pause = pause_.load(std::memory_order_relaxed);
        const Clock::duration first = kFirstPause, longest = kLongestPause;
        if (end - begin < kSlow) {
            pause_.store(std::max(first.count(), pause / 2), std::memory_order_relaxed);
        } else {
            notBefore_.store(end.time_since_epoch().count() + pause, std::memory_order_relaxed);
            pause_.store(std::min(longest.count(), 4 * pause), std::memory_order_relaxed);
        }
    }

 private:
    // Threads may overwrite each other's news, which does no harm.
    std::atomic<Clock::rep> notBefore_{std::numeric_limits<Clock::rep>::min()};
    std::atomic<Clock::rep> pause_{Clock::duration(kFirstPause).count()};
};

}  // namespace superray
