// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file node_arena.h
/// Memory for the nodes of a tree, made by one or several threads.

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

namespace superray {

/// Hands out nodes of 16 bytes and families (the pointers to 8 children) of
/// 64. What is made in turn lies side by side. What is released is used again;
/// memory goes back only with the arena.
class NodeArena {
 public:
    static constexpr std::size_t kNodeBytes = 16, kFamilyBytes = 64;
    /// Chunks double with the arena, from the first to the last of these sizes.
    static constexpr std::size_t kFirstChunk = std::size_t{1} << 16;
    static constexpr std::size_t kLastChunk = std::size_t{1} << 21;

    class Share;

    NodeArena() = default;
    NodeArena(const NodeArena&) = delete;
    NodeArena& operator=(const NodeArena&) = delete;

    /// \pre no shares of either
    void swap(NodeArena& o) noexcept;
    void clear() noexcept;  ///< \pre no shares
    /// Has so many bytes that were never used at hand, touched.
    /// \throws std::bad_alloc  \pre no shares
    void reserve(std::size_t bytes);
    /// Memory taken from the system.
    std::size_t chunkBytes() const { return chunkBytes_; }
    /// What of that was reserved and no share has taken yet.
    std::size_t reservedBytes() const { return reserved_.size() * kLastChunk; }

    /// What shares are about to take, by calls of Share::reserve(step) before each `step`
    /// bytes at most.
    struct Demand {
        std::size_t nodes, families;
        std::size_t step;  ///< [bytes]
        std::size_t shares = 1;
    };
    /// The most that chunkBytes() can be then. \pre no shares
    std::size_t chunkBytesAtMost(const Demand& demand) const;
    /// Makes sure that the demand can be met without failure. Nothing touches the memory
    /// that this takes, and chunkBytes() counts it when shares take it.
    /// \throws std::bad_alloc, and takes nothing then  \pre no shares
    void keepRoom(const Demand& demand);

 private:
    struct Free {
        Free* next;
    };
    /// Last in, first out.
    struct FreeList {
        Free* first = nullptr;
        Free* last = nullptr;  // valid if there is a first
        std::size_t count = 0;
        void push(void* memory);
        void* pop();
        void append(FreeList& o);          // takes all of o
        FreeList takeSome(std::size_t n);  // at most n
    };
    struct Range {
        std::byte* begin = nullptr;
        std::byte* end = nullptr;
        std::size_t size() const { return static_cast<std::size_t>(end - begin); }
    };
    struct Chunk {
        std::unique_ptr<std::byte[]> memory;
        std::size_t bytes = 0;
    };
    /// Size of a new chunk for an arena of so many bytes.
    static std::size_t chunkSize(std::size_t arenaBytes, std::size_t least);
    Range findChunk(std::size_t least);
    Range newChunk(std::size_t least);
    static Chunk makeChunk(std::size_t bytes);
    Range addChunk(Chunk chunk);
    void noteFree() {
        freeNodes_ = nodes_.first != nullptr;
        freeFamilies_ = families_.first != nullptr;
    }
    /// So that shares can give back what they have without allocating.
    void keepRoomForRanges() { ranges_.reserve(ranges_.size() + 2 * shares_ + 1); }

    std::mutex mutex_;  // of what follows, while there are shares
    std::vector<std::unique_ptr<std::byte[]>> chunks_;
    std::vector<Range> ranges_;    // never used so far
    std::vector<Range> reserved_;  // touched, of kLastChunk bytes each
    std::vector<Chunk> room_;      // of keepRoom(), the next one first
    FreeList nodes_, families_;
    std::size_t chunkBytes_ = 0;
    std::size_t shares_ = 0;
    std::atomic<bool> freeNodes_{false}, freeFamilies_{false};  // are there any
};

/// One thread's access to an arena.
class NodeArena::Share {
 public:
    explicit Share(NodeArena& arena);
    ~Share();  ///< gives back what was not used
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;

    /// Makes sure that memory of `bytes` in total, in whatever parts, can be
    /// taken without failure.
    void reserve(std::size_t bytes) {
        if (current_.size() < bytes && spare_.size() < bytes) findRoom(bytes);
    }
    // Uninitialised memory. \pre reserve()
    // Released memory is taken first, so that it does not pile up beside new memory.
    void* node() {
        return hasFree(nodes_, arena_.freeNodes_) ? nodes_.pop() : take(kNodeBytes);
    }
    /// Nodes side by side, if that is easy; else nullptr.
    std::byte* nodesInARow(std::size_t n) {
        if (hasFree(nodes_, arena_.freeNodes_) || current_.size() < n * kNodeBytes)
            return nullptr;
        return std::exchange(current_.begin, current_.begin + n * kNodeBytes);
    }
    void* family() {
        return hasFree(families_, arena_.freeFamilies_) ? families_.pop() : take(kFamilyBytes);
    }
    void releaseNode(void* node) { nodes_.push(node); }
    void releaseFamily(void* family) { families_.push(family); }

 private:
    void* take(std::size_t bytes) {
        if (current_.size() < bytes) useSpare();
        void* const memory = current_.begin;
        current_.begin += bytes;
        return memory;
    }
    void useSpare();
    void findRoom(std::size_t bytes);
    /// Whether a list of this share has memory, after asking the arena for some.
    bool hasFree(FreeList& mine, const std::atomic<bool>& arenaHas) {
        if (mine.first == nullptr && arenaHas.load(std::memory_order_relaxed)) findFree();
        return mine.first != nullptr;
    }
    void findFree();

    NodeArena& arena_;
    Range current_, spare_;
    FreeList nodes_, families_;
    std::size_t freeAtOnce_ = 8;  // what findFree() takes: more and more
};

inline void NodeArena::FreeList::push(void* memory) {
    Free* const slot = new (memory) Free{first};
    if (first == nullptr) last = slot;
    first = slot;
    ++count;
}

inline void* NodeArena::FreeList::pop() {
    Free* const slot = first;
    first = slot->next;
    --count;
    return slot;
}

}  // namespace superray
