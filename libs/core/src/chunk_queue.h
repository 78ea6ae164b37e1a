#pragma once
// Chunks of work for several threads: each begins with its own share, in order,
// and helps the others out from the ends of theirs.

#include <superray/core/parallel.h>

#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

namespace superray {

class ChunkQueue {
 public:
    ChunkQueue(std::size_t chunks, std::size_t shares) : left_(shares) {
        for (std::size_t s = 0; s < shares; ++s)
            left_[s] = pack(shareBegin(chunks, s, shares), shareBegin(chunks, s + 1, shares));
    }

    /// The next chunk for a thread; nothing when all are taken.
    std::optional<std::size_t> take(std::size_t share) {
        for (std::size_t i = 0; i < left_.size(); ++i)
            if (const auto chunk =
                    takeFrom((share + i) % left_.size(), i == 0 ? From::front : From::back))
                return chunk;
        return std::nullopt;
    }

 private:
    enum class From { front, back };

    /// Chunks [begin, end) of a share in one word, so that both change at once.
    static std::uint64_t pack(std::uint64_t begin, std::uint64_t end) {
        return begin << 32 | end;
    }

    std::optional<std::size_t> takeFrom(std::size_t share, From from) {
        std::atomic<std::uint64_t>& left = left_[share];
        std::uint64_t now = left.load(std::memory_order_relaxed);
        for (;;) {
            const std::uint64_t begin = now >> 32, end = now & 0xFFFFFFFF;
            if (begin == end) return std::nullopt;
            const std::uint64_t then =
                from == From::front ? pack(begin + 1, end) : pack(begin, end - 1);
            if (left.compare_exchange_weak(now, then, std::memory_order_relaxed))
                return from == From::front ? begin : end - 1;
        }
    }

    std::vector<std::atomic<std::uint64_t>> left_;
};

}  // namespace superray
