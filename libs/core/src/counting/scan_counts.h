// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Hits and misses of a scan, as one thread counts them.

#include <superray/core/update_batch.h>

#include "counting/address_buffer.h"
#include "counting/block_directory.h"
#include "threads/interleave.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace superray {

/// Update batch of one thread, with what makes counting fast: a directory of its blocks, and
/// a buffer of free cells. Kernels append cells to the buffer; flush() counts them.
template <int Dim>
struct ScanCounts {
    BlockDirectory<Dim> directory;  ///< block -> its index in the batch + 1
    UpdateBatch<Dim> batch;
    AddressBuffer addresses;
    std::uint64_t traversed = 0;  ///< free cells counted, one for each ray

    /// Begins a scan. \param box blocks that it may touch
    void reset(const BlockBox<Dim>& box) {
        batch.clear();
        directory.reset(box);
        hitBlocks_.clear();
        hitOffsets_.clear();
        traversed = 0;
    }
    /// Sets the number of hits from which on more hits, and misses, change nothing. Counts do
    /// not reach numbers above 255.
    void setHitsToSaturate(std::uint32_t hits) { hitsToSaturate_ = hits; }
    /// Offset of a block's hit counts in the arena; the block is made on first use.
    std::uint32_t hitOffset(const BlockKey<Dim>& key) { return makeHitOffset(batchBlock(key)); }
    /// The same, for the block at this index of the directory.
    /// \param keyOf gives the block's key; called only if the block has no hits yet
    /// \pre the directory is dense
    template <typename KeyOf>
    std::uint32_t hitOffset(std::uint32_t index, const KeyOf& keyOf) {
        const std::uint32_t n = directory.data()[index];
        if (n < hitOffsets_.size() && hitOffsets_[n] != kNoOffset) return hitOffsets_[n];
        return makeHitOffset(n == 0 ? batchBlock(keyOf()) : n - 1);
    }
    /// The number of hits that need to be counted.
    std::uint8_t mostHits() const {
        return static_cast<std::uint8_t>(std::min(hitsToSaturate_, kMaxCount));
    }
    /// Offset of nothing.
    static constexpr std::uint32_t kNoOffset = ~std::uint32_t{0};
    /// Gives the greatest miss count to cells whose hits decide their value, however many
    /// misses there are. Such cells are settled: walks need not count their misses.
    void settleSaturatedHits() {
        for (const std::uint32_t b : hitBlocks_) {
            const std::uint8_t* const hits = batch.hits(b);
            std::uint8_t* const misses = batch.missesOf(b);
            for (int i = 0; i < kBlockCells<Dim>; ++i)
                misses[i] = hits[i] >= hitsToSaturate_ ? std::uint8_t{kMaxCount} : misses[i];
            hitOffsets_[b + 1] = kNoOffset;
        }
        hitBlocks_.clear();
    }
    /// Offset of a block's miss counts in the arena; the block is made on first use.
    std::uint32_t offsetOf(const BlockKey<Dim>& key) { return offset(idOf(key)); }
    /// The block's number in the directory, made on first use.
    std::uint32_t idOf(const BlockKey<Dim>& key) {
        const std::uint32_t n = directory.id(key);
        if (n != 0) return n;
        const std::uint32_t made = batch.addBlock(key) + 1;
        directory.setId(key, made);
        return made;
    }
    /// Offset of the counts that a directory number stands for. \pre number != 0
    static std::uint32_t offset(std::uint32_t id) {
        return (id - 1) * static_cast<std::uint32_t>(kBlockCells<Dim>);
    }
    /// Batch block of a block with counts; nothing for others.
    std::optional<std::uint32_t> ownBatchBlock(const BlockKey<Dim>& key) const {
        const std::uint32_t n = directory.id(key);
        if (n == 0) return std::nullopt;
        return n - 1;
    }
    /// Batch block of a block, made on first use.
    std::uint32_t batchBlock(const BlockKey<Dim>& key) { return idOf(key) - 1; }
    /// Adds `weight` to every address and forgets them.
    void flush(std::uint32_t weight) {
        std::uint8_t* counts = batch.missArena();
        traversed += addresses.size();
        const std::uint32_t* const at = addresses.begin();
        if (weight == 1) {
            // Rays side by side visit the same cells one after the other.
            interleave(addresses.size(), [&](std::size_t, std::size_t i) {
                std::uint8_t& count = counts[at[i]];
                std::uint8_t more;
                // Two instructions: the carry is taken off again.
                const bool carry = __builtin_add_overflow(count, std::uint8_t{1}, &more);
                count = static_cast<std::uint8_t>(more - carry);
            });
        } else {
            for (std::size_t i = 0, n = addresses.size(); i < n; ++i)
                counts[at[i]] = saturatingAdd(counts[at[i]], weight);
        }
        addresses.clear();
    }

    static std::uint8_t saturatingAdd(std::uint8_t count, std::uint32_t weight) {
        return static_cast<std::uint8_t>(weight > kMaxCount - count ? kMaxCount
                                                                    : count + weight);
    }

 private:
    static constexpr std::uint32_t kMaxCount = UpdateBatch<Dim>::kMaxCount;

    std::uint32_t makeHitOffset(std::uint32_t block) {
        if (block + 1 >= hitOffsets_.size())
            hitOffsets_.resize(batch.blockCount() + 1, kNoOffset);
        std::uint32_t& offset = hitOffsets_[block + 1];
        if (offset == kNoOffset) {
            hitBlocks_.push_back(block);
            offset = static_cast<std::uint32_t>(batch.hitsOf(block) - batch.hitArena());
        }
        return offset;
    }

    std::uint32_t hitsToSaturate_ = 0;
    std::vector<std::uint32_t> hitBlocks_;   // got hits since settleSaturatedHits()
    std::vector<std::uint32_t> hitOffsets_;  // of these, by number in the directory
};

}  // namespace superray
