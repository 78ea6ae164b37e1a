// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A list that its owner works off, helped by threads that have nothing else to do.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <thread>

namespace superray {

/// Some of a list: [begin, end).
struct WorkPiece {
    std::size_t begin, end;
};

class WorkQueue {
 public:
    /// By the owner: a list of `size` things is there to be worked off. What it
    /// published before must be taken. \pre size < 2^32
    void publish(std::size_t size) { left_.store(size, std::memory_order_release); }
    /// By anyone: some things that are left; nothing when all are taken.
    std::optional<WorkPiece> take() {
        std::uint64_t now = left_.load(std::memory_order_relaxed);
        for (;;) {
            const std::uint64_t begin = now >> 32, end = now & 0xFFFFFFFF;
            if (begin == end) return std::nullopt;
            const std::uint64_t next = std::min(begin + kAtOnce, end);
            if (left_.compare_exchange_weak(now, next << 32 | end, std::memory_order_acquire,
                                            std::memory_order_relaxed))
                return WorkPiece{begin, next};
        }
    }

    /// By the owner: there will be lists, and nothing is left of earlier ones; there
    /// will be no more, and all is taken (unless the owner failed).
    void start() {
        left_.store(0, std::memory_order_relaxed);
        running_.store(true, std::memory_order_release);
    }
    void finish() { running_.store(false, std::memory_order_release); }
    /// By others: work(piece) as long as there will be lists.
    template <typename Work>
    void help(const Work& work) {
        while (running_.load(std::memory_order_acquire)) {
            while (const auto piece = take()) work(*piece);
            std::this_thread::yield();
        }
    }

 private:
    /// Small enough to share evenly, large enough to seldom meet.
    static constexpr std::uint64_t kAtOnce = 512;

    std::atomic<std::uint64_t> left_{0};  // begin << 32 | end
    std::atomic<bool> running_{false};
};

}  // namespace superray
