#pragma once
/// \file chunked_pool.h
/// Objects addressed by number, in chunks that never move.

#include <algorithm>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <vector>

namespace superray {

/// Released numbers are used again; memory goes back only with the pool.
template <typename T, std::uint32_t kChunk>
class ChunkedPool {
    static_assert((kChunk & (kChunk - 1)) == 0, "a power of two divides fast");
    static_assert(std::is_trivially_copyable_v<T>);

 public:
    ChunkedPool() = default;
    ChunkedPool(const ChunkedPool& o) : free_(o.free_), used_(o.used_) {
        for (const auto& chunk : o.chunks_) {
            addChunk();
            std::copy_n(chunk.get(), kChunk, chunks_.back().get());
        }
    }
    ChunkedPool(ChunkedPool&&) noexcept = default;
    ChunkedPool& operator=(ChunkedPool&&) noexcept = default;

    T& operator[](std::uint32_t i) { return chunks_[i / kChunk][i % kChunk]; }
    const T& operator[](std::uint32_t i) const { return chunks_[i / kChunk][i % kChunk]; }

    /// Number of an object with unspecified contents.
    std::uint32_t allocate() {
        if (!free_.empty()) {
            const std::uint32_t i = free_.back();
            free_.pop_back();
            return i;
        }
        if (used_ == chunks_.size() * kChunk) addChunk();
        return used_++;
    }
    void release(std::uint32_t i) { free_.push_back(i); }

    void clear() {
        chunks_.clear();
        free_.clear();
        used_ = 0;
    }

    std::size_t memoryBytes() const {
        return chunks_.size() * kChunk * sizeof(T) + chunks_.capacity() * sizeof(chunks_[0]) +
               free_.capacity() * sizeof(free_[0]);
    }

 private:
    void addChunk() { chunks_.emplace_back(new T[kChunk]); }

    std::vector<std::unique_ptr<T[]>> chunks_;
    std::vector<std::uint32_t> free_;
    std::uint32_t used_ = 0;
};

}  // namespace superray
