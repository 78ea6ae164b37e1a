// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <thread>
#include <vector>

namespace superray::test {

/// Threads that keep processors busy as long as it lives, as other programs would.
class BusyThreads {
 public:
    explicit BusyThreads(unsigned count) {
        for (unsigned i = 0; i < count; ++i)
            threads_.emplace_back([this] {
                while (!done_.load(std::memory_order_relaxed)) {
                }
            });
    }
    ~BusyThreads() {
        done_ = true;
        for (auto& thread : threads_) thread.join();
    }
    BusyThreads(const BusyThreads&) = delete;
    BusyThreads& operator=(const BusyThreads&) = delete;

 private:
    std::atomic<bool> done_{false};
    std::vector<std::thread> threads_;
};

}  // namespace superray::test
