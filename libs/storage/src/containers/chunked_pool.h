// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file chunked_pool.h
/// Objects addressed by number, in chunks that never move.

#include <superray/core/detail/grow.h>

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
    static_assert(std::is_trivially_copyable_v<T> && sizeof(T) >= sizeof(std::uint32_t));

 public:
    ChunkedPool() = default;
    ChunkedPool(const ChunkedPool& o) : lastFree_(o.lastFree_), free_(o.free_), used_(o.used_) {
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
        if (free_ > 0) {
            const std::uint32_t i = lastFree_;
            std::memcpy(&lastFree_, static_cast<const void*>(&(*this)[i]), sizeof lastFree_);
            --free_;
            return i;
        }
        if (used_ == chunks_.size() * kChunk) addSlab(slabSize());
        return used_++;
    }
    /// The next allocate() gives this number. What is released keeps the number that was
    /// released before it, so that this needs no memory and cannot fail.
    void release(std::uint32_t i) {
        std::memcpy(static_cast<void*>(&(*this)[i]), &lastFree_, sizeof lastFree_);
        lastFree_ = i;
        ++free_;
    }

    /// Makes sure that so many can be allocated without failure. Nothing touches the memory
    /// that this takes, so it is only counted when it is used.
    /// \throws std::bad_alloc, std::length_error
    void keepRoom(std::size_t n) {
        const std::size_t had = free_ + chunks_.size() * kChunk - used_;
        if (had < n) addSlab(std::max(chunksOf(n - had), slabSize()));
    }

    /// So that so many bytes of objects can be given out without asking the system: their
    /// memory has been touched. \throws std::bad_alloc, std::length_error
    void reserve(std::size_t bytes) {
        const std::size_t wanted = usedChunks() + bytes / (kChunk * sizeof(T));
        if (wanted > chunks_.size()) addSlab(wanted - chunks_.size());
        // Not of T's: they are made when they are given out.
        for (std::size_t i = takenChunks(); i < wanted; ++i)
            std::memset(static_cast<void*>(chunks_[i]), 0, kChunk * sizeof(T));
        touched_ = std::max(touched_, wanted);
    }

    void clear() {
        slabs_.clear();
        chunks_.clear();
        free_ = 0;
        used_ = 0;
        touched_ = 0;
    }

    /// Of what was used or touched.
    std::size_t memoryBytes() const { return bytesOf(takenChunks()); }
    /// The most that memoryBytes() can be after so many calls of allocate().
    std::size_t memoryBytesAtMost(std::size_t allocated) const {
        const std::size_t used = used_ + allocated - std::min(allocated, free_);
        return bytesOf(std::max(chunksOf(used), touched_));
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

    std::size_t slabSize() const {
        return std::clamp<std::size_t>(chunks_.size() / kSpare, 1, kMostChunks);
    }
    static std::size_t chunksOf(std::size_t objects) { return (objects + kChunk - 1) / kChunk; }
    std::size_t usedChunks() const { return chunksOf(used_); }
    std::size_t takenChunks() const { return std::max(usedChunks(), touched_); }
    /// With their places in the table, which may double.
    static std::size_t bytesOf(std::size_t chunks) {
        return chunks * (kChunk * sizeof(T) + 2 * sizeof(void*));
    }

    void addSlab(std::size_t chunks) {
        constexpr std::size_t kMost = (std::size_t{1} << 32) / kChunk - 1;
        if (chunks_.size() + chunks > kMost)
            throw std::length_error("a map holds fewer than 2^32 blocks, layers or nodes");
        detail::growBy(chunks_, chunks);
        slabs_.emplace_back(chunks);  // nothing fails from here on
        for (std::size_t i = 0; i < chunks; ++i)
            chunks_.push_back(slabs_.back().memory.get() + i * kChunk);
    }

    std::vector<Slab> slabs_;
    std::vector<T*> chunks_;
    std::uint32_t lastFree_ = 0;  ///< that was released last, if any is free
    std::size_t free_ = 0;        ///< numbers that were released
    std::uint32_t used_ = 0;      ///< numbers that were ever given out
    std::size_t touched_ = 0;     ///< chunks that reserve() has touched, or less
};

}  // namespace superray
