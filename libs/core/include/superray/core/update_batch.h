// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file update_batch.h
/// What one scan does to a map: per cell, how many rays miss and how many hit.

#include <superray/core/block.h>
#include <superray/core/detail/large_memory.h>

#include <cstdint>
#include <vector>

namespace superray {

/// Per-cell miss and hit counts of a scan in 8^Dim blocks.
///
/// Counts are 8 bit and saturate at 255: the sensor model needs at most
/// missesToSaturate() (default 15) of them, beyond which more change nothing.
/// (ScanIntegrator counts exactly by another way where a model needs more.)
template <int Dim>
class UpdateBatch {
 public:
    static constexpr int kCells = kBlockCells<Dim>;
    static constexpr std::uint32_t kMaxCount = 255;

    std::size_t blockCount() const { return keys_.size(); }
    const BlockKey<Dim>& key(std::size_t block) const { return keys_[block]; }
    /// kCells miss counts, index as indexInBlock().
    const std::uint8_t* misses(std::size_t block) const {
        return block < own() ? misses_.data() + slot(block) : borrowed_[block - own()].misses;
    }
    /// kCells hit counts, or nullptr if no ray ends in this block.
    const std::uint8_t* hits(std::size_t block) const {
        if (block >= own()) return borrowed_[block - own()].hits;
        return hitSlots_[block] < 0 ? nullptr : hits_.data() + hitSlot(block);
    }
    /// Cells with a miss or a hit (a block may have none: skip it).
    BlockMask<Dim> touched(std::size_t block) const;

    // --- building -----------------------------------------------------------
    /// Appends a block with zero counts. Each key may be added once.
    std::uint32_t addBlock(const BlockKey<Dim>& key);
    /// Zero-initialised hit counts of a block, made on first use.
    std::uint8_t* hitsOf(std::uint32_t block);
    /// All hit counts: hitsOf() points into it until the next block gets some.
    std::uint8_t* hitArena() { return hits_.data(); }
    std::uint8_t* missesOf(std::uint32_t block) { return misses_.data() + slot(block); }
    /// All miss counts, block by block, for walks.
    std::uint8_t* missArena() { return misses_.data(); }
    /// Appends a block with counts that another batch keeps. No block can be
    /// added afterwards. \param hits may be nullptr
    void borrowBlock(const BlockKey<Dim>& key, const std::uint8_t* misses,
                     const std::uint8_t* hits) {
        keys_.push_back(key);
        borrowed_.push_back({misses, hits});
    }
    /// Forgets all blocks; keeps the memory.
    void clear();
    /// Forgets all blocks, and has about so many bytes of memory at hand, touched.
    /// \throws std::bad_alloc
    void reserve(std::size_t bytes);
    std::size_t memoryBytes() const;

 private:
    static std::size_t slot(std::size_t block) { return block * kCells; }
    std::size_t hitSlot(std::size_t block) const {
        return static_cast<std::size_t>(hitSlots_[block]) * kCells;
    }

    struct Borrowed {
        const std::uint8_t* misses;
        const std::uint8_t* hits;
    };
    std::size_t own() const { return hitSlots_.size(); }

    std::vector<BlockKey<Dim>> keys_;  // own ones, then borrowed ones
    std::vector<Borrowed> borrowed_;
    std::vector<std::int32_t> hitSlots_;  // -1: none
    ZeroedBytes misses_, hits_;
};

extern template class UpdateBatch<2>;
extern template class UpdateBatch<3>;

}  // namespace superray
