// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file chunked_pool.h
/// Objects addressed by number, in chunks that never move.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
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
        // Not those that were reserved and never used.
        if (used_ > 0) addSlab(usedChunks());
        for (std::size_t i = 0; i < usedChunks(); ++i)
            std::memcpy(chunks_[i], o.chunks_[i], kChunk * sizeof(T));
    }
    ChunkedPool(ChunkedPool&&) noexcept = default;
    ChunkedPool& operator=(ChunkedPool&&) noexcept = default;

    T& operator[](std::uint32_t i) { return chunks_[i / kChunk][i % kChunk]; }
    const T& operator[](std::uint32_t i) const { return chunks_[i / kChunk][i % kChunk]; }

    /// Number of an object with unspecified contents. The greatest numbers, kChunk of them,
    /// are never given out: callers may use them as marks.
    /// \throws std::length_error if there is no other left
    std::uint32_t allocate() {
        if (!free_.empty()) {
            const std::uint32_t i = free_.back();
            free_.pop_back();
            return i;
        }
        if (used_ == chunks_.size() * kChunk) addSlab(slabSize());
        return used_++;
    }
    /// So that so many can be allocated without failure, after which the greatest number
    /// may be kChunk higher. \throws std::bad_alloc, std::length_error
    void keepRoomToAllocate(std::uint32_t n) {
        const std::size_t room = free_.size() + chunks_.size() * kChunk - used_;
        if (room < n)
            addSlab(std::max<std::size_t>((n - room + kChunk - 1) / kChunk, slabSize()));
    }
    void release(std::uint32_t i) { free_.push_back(i); }
    /// So that so many can be released without failure.
    void keepRoomToRelease(std::size_t n) {
        if (free_.capacity() - free_.size() < n)
            free_.reserve(std::max(2 * free_.capacity(), free_.size() + n));
    }

    /// So that so many bytes of objects can be given out without asking the system: their
    /// memory has been touched. \throws std::bad_alloc, std::length_error
    void reserve(std::size_t bytes) {
        constexpr std::size_t kChunkBytes = kChunk * sizeof(T);
        const std::size_t wanted = bytes / kChunkBytes;
        const std::size_t unused = chunks_.size() - usedChunks();
        if (wanted <= unused) return;
        addSlab(wanted - unused);
        // Not of T's: they are made when they are given out.
        std::memset(static_cast<void*>(slabs_.back().memory.get()), 0,
                    (wanted - unused) * kChunkBytes);
    }

    void clear() {
        slabs_.clear();
        chunks_.clear();
        free_.clear();
        used_ = 0;
    }

    std::size_t memoryBytes() const {
        return chunks_.size() * kChunk * sizeof(T) + chunks_.capacity() * sizeof(void*) +
               slabs_.capacity() * sizeof(slabs_[0]) + free_.capacity() * sizeof(free_[0]);
    }
    /// The most that memoryBytes() can be after so many calls of allocate() and release().
    std::size_t memoryBytesAtMost(std::size_t allocated, std::size_t released) const {
        std::size_t chunks = chunks_.size(), slabs = slabs_.size();
        std::size_t room = free_.size() + chunks * kChunk - used_;
        while (room < allocated) {
            const std::size_t added = slabSize(chunks);
            chunks += added;
            room += added * kChunk;
            ++slabs;
        }
        const auto grown = [](std::size_t size, std::size_t capacity) {
            return size <= capacity ? capacity : 2 * size;
        };
        return chunks * kChunk * sizeof(T) + grown(chunks, chunks_.capacity()) * sizeof(void*) +
               grown(slabs, slabs_.capacity()) * sizeof(slabs_[0]) +
               grown(free_.size() + released, free_.capacity()) * sizeof(free_[0]);
    }

 private:
    /// Chunks are allocated several at once: a small request to the allocator costs a page
    /// fault. Nobody touches them until an object is filled in, which one of several
    /// threads may do.
    struct Slab {
        static constexpr std::align_val_t kAlignment{alignof(T)};
        struct Delete {
            void operator()(T* chunks) const { ::operator delete(chunks, kAlignment); }
        };
        std::unique_ptr<T, Delete> memory;
        explicit Slab(std::size_t chunks)
            : memory(static_cast<T*>(::operator new(chunks* kChunk * sizeof(T), kAlignment))) {}
    };
    static constexpr std::size_t kMostChunks = 64;  ///< in a slab
    static constexpr std::size_t kSpare = 128;      ///< of so many chunks, one may be unused

    static std::size_t slabSize(std::size_t chunks) {
        return std::clamp<std::size_t>(chunks / kSpare, 1, kMostChunks);
    }
    std::size_t slabSize() const { return slabSize(chunks_.size()); }
    std::size_t usedChunks() const { return (std::size_t{used_} + kChunk - 1) / kChunk; }

    void addSlab(std::size_t chunks) {
        constexpr std::size_t kMost = (std::size_t{1} << 32) / kChunk - 1;
        if (chunks_.size() + chunks > kMost)
            throw std::length_error("a map holds fewer than 2^32 blocks, layers or nodes");
        if (chunks_.capacity() - chunks_.size() < chunks)
            chunks_.reserve(std::max(chunks_.size() + chunks, 2 * chunks_.capacity()));
        slabs_.emplace_back(chunks);  // nothing fails from here on
        for (std::size_t i = 0; i < chunks; ++i)
            chunks_.push_back(slabs_.back().memory.get() + i * kChunk);
    }

    std::vector<Slab> slabs_;
    std::vector<T*> chunks_;
    std::vector<std::uint32_t> free_;
    std::uint32_t used_ = 0;
};

}  // namespace superray
