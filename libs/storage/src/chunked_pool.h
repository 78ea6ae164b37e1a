#pragma once
/// \file chunked_pool.h
/// Objects addressed by number, in chunks that never move.

#include <superray/core/large_memory.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <new>
#include <type_traits>
#include <vector>

namespace superray {

/// Released numbers are used again; memory goes back only with the pool. Large pools
/// grow by slabs of a huge page, whose first touch takes a fraction of that of as many
/// small ones.
template <typename T, std::uint32_t kChunk>
class ChunkedPool {
    static_assert((kChunk & (kChunk - 1)) == 0, "a power of two divides fast");
    static_assert(std::is_trivially_copyable_v<T>);
    static constexpr std::size_t kChunkBytes = kChunk * sizeof(T);
    static_assert(kChunkBytes <= kHugePage);

 public:
    ChunkedPool() = default;
    ChunkedPool(const ChunkedPool& o) : free_(o.free_), used_(o.used_) {
        for (const T* const chunk : o.chunks_) {
            addChunk();
            std::copy_n(chunk, kChunk, chunks_.back());
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
        small_.clear();
        slabs_.clear();
        free_.clear();
        used_ = 0;
    }

    std::size_t memoryBytes() const {
        return small_.size() * kChunkBytes + slabs_.size() * kHugePage +
               chunks_.capacity() * sizeof(chunks_[0]) + free_.capacity() * sizeof(free_[0]);
    }

 private:
    static constexpr std::size_t kSlabChunks = kHugePage / kChunkBytes;
    static constexpr std::size_t kSmallChunks = 2 * kSlabChunks;

    void addChunk() {
        if (chunks_.size() < kSmallChunks) {
            small_.emplace_back(new T[kChunk]);
            chunks_.push_back(small_.back().get());
            return;
        }
        const std::size_t inSlab = (chunks_.size() - kSmallChunks) % kSlabChunks;
        if (inSlab == 0) {
            slabs_.emplace_back(kHugePage);
            slabs_.back().expectWrites(kHugePage);
        }
        std::byte* const begin = slabs_.back().data() + inSlab * kChunkBytes;
        chunks_.push_back(new (begin) T[kChunk]);
    }

    std::vector<T*> chunks_;
    std::vector<std::unique_ptr<T[]>> small_;  // the first ones
    std::vector<LargeMemory> slabs_;           // what the others are in
    std::vector<std::uint32_t> free_;
    std::uint32_t used_ = 0;
};

}  // namespace superray
