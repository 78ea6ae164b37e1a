// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file large_memory.h
/// Memory of arrays that may become large and grow while they are filled; no public
/// interface. It is here since UpdateBatch, which is public, has such arrays.

#include <cstddef>
#include <cstdint>

namespace superray {

/// Size of the huge pages of a system that has 4 KiB pages.
inline constexpr std::size_t kHugePage = std::size_t{1} << 21;

/// An area of memory that can grow.
///
/// On Linux, areas of a huge page or more come straight from the system: what is
/// never written takes no memory, and growing moves pages instead of copying
/// them. They are made of huge pages as far as the system has such at hand: one
/// page fault instead of 512, and fewer TLB misses. That repays its cost in memory
/// that is used again at every scan; in a map, which touches new memory at every
/// scan, it does not on virtual machines.
class LargeMemory {
 public:
    LargeMemory() = default;
    /// At least so many bytes, of unspecified contents. \throws std::bad_alloc
    explicit LargeMemory(std::size_t bytes);
    LargeMemory(LargeMemory&& o) noexcept { swap(o); }
    LargeMemory& operator=(LargeMemory&& o) noexcept {
        swap(o);
        return *this;
    }
    ~LargeMemory();

    void swap(LargeMemory& o) noexcept;
    std::byte* data() const { return data_; }
    std::size_t size() const { return size_; }
    /// Makes the size at least `bytes`. The area may move; it keeps its contents.
    /// \throws std::bad_alloc, and leaves the area as it was
    void grow(std::size_t bytes);
    /// Must be called before anything beyond the bytes of the last call is written:
    /// chooses the pages of the first `bytes` bytes. \pre bytes <= size()
    void expectWrites(std::size_t bytes) {
        if (mapped_ && bytes > chosen_) choosePages(bytes);
    }

 private:
    void choosePages(std::size_t bytes);

    std::byte* data_ = nullptr;
    std::size_t size_ = 0;
    std::size_t chosen_ = 0;  // pages are chosen up to here
    bool mapped_ = false, huge_ = false;
};

/// An array of bytes to which zeros are appended.
class ZeroedBytes {
 public:
    /// What may be read beyond the end, by vector loads.
    static constexpr std::size_t kSlack = 64;

    ZeroedBytes() = default;
    ZeroedBytes(const ZeroedBytes& o);
    ZeroedBytes(ZeroedBytes&& o) noexcept { swap(o); }
    ZeroedBytes& operator=(ZeroedBytes o) noexcept {
        swap(o);
        return *this;
    }

    std::size_t size() const { return size_; }
    std::size_t capacity() const { return memory_.size(); }
    std::uint8_t* data() { return reinterpret_cast<std::uint8_t*>(memory_.data()); }
    const std::uint8_t* data() const {
        return reinterpret_cast<const std::uint8_t*>(memory_.data());
    }
    /// Appends n zeros. \throws std::bad_alloc, and leaves the array as it was
    void append(std::size_t n);
    /// Forgets the bytes from `size` on, but keeps their memory. \pre size <= size()
    void shrink(std::size_t size) { size_ = size; }

 private:
    void swap(ZeroedBytes& o) noexcept;

    LargeMemory memory_;
    std::size_t size_ = 0;
};

}  // namespace superray
