// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A list that its owner works off in pieces, with the help of idle threads.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <thread>

namespace superray {

/// Elements [begin, end) of a list.
struct WorkPiece {
    std::size_t begin, end;
};

/// Hands out the pieces of its owner's lists, each piece once. Lock-free.
class WorkQueue {
 public:
    /// The time in which helpers wait for pieces. Ends with its scope, also by an exception.
    class Round {
     public:
        explicit Round(WorkQueue& queue) : queue_(queue) {
            queue_.left_.store(0, std::memory_order_relaxed);
            queue_.running_.store(true, std::memory_order_release);
        }
        ~Round() { queue_.running_.store(false, std::memory_order_release); }
        Round(const Round&) = delete;
        Round& operator=(const Round&) = delete;

     private:
        WorkQueue& queue_;
    };

    /// Offers a list of `size` elements. What the owner wrote before is visible to whoever
    /// takes a piece. \pre called by the owner; the list before is taken; size < 2^32
    void publish(std::size_t size) { left_.store(size, std::memory_order_release); }

    /// The next piece; nothing when all are taken.
    std::optional<WorkPiece> take() {
        std::uint64_t now = left_.load(std::memory_order_relaxed);
        for (;;) {
            const std::uint64_t begin = now >> 32, end = now & 0xFFFFFFFF;
            if (begin == end) return std::nullopt;
            const std::uint64_t next = std::min(begin + kPiece, end);
            if (left_.compare_exchange_weak(now, next << 32 | end, std::memory_order_acquire,
                                            std::memory_order_relaxed))
                return WorkPiece{begin, next};
        }
    }

    /// Calls work(piece) for pieces, until the owner's round is over. Does nothing if there
    /// is no round.
    template <typename Work>
    void help(const Work& work) {
        while (running_.load(std::memory_order_acquire)) {
            while (const auto piece = take()) work(*piece);
            std::this_thread::yield();
        }
    }

 private:
    /// Elements per piece: few enough to spread evenly, enough to make contention rare.
    static constexpr std::uint64_t kPiece = 512;

    std::atomic<std::uint64_t> left_{0};  // begin << 32 | end
    std::atomic<bool> running_{false};
};

}  // namespace superray
