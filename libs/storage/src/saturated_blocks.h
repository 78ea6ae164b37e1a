#pragma once
/// \file saturated_blocks.h
/// Which cells of which blocks are saturated free, beside a tree.

#include "block_table.h"
#include "chunked_pool.h"
#include "saturation_clamp.h"

namespace superray {

/// A mask per block with a saturated cell; saturated blocks share one.
template <int Dim>
class SaturatedBlocks {
 public:
    SaturationClamp clamp;

    /// nullptr if no cell is saturated; valid until the next put()
    const BlockMask<Dim>* find(const BlockKey<Dim>& key) const {
        static const BlockMask<Dim> full = fullMask<Dim>();
        const std::uint32_t slot = table_.find(key);
        if (slot == kFull) return &full;
        return hasOwnMask(slot) ? &masks_[slot - kFirstMask] : nullptr;
    }

    void put(const BlockKey<Dim>& key, const BlockMask<Dim>& mask) {
        std::uint32_t slot = table_.find(key);
        if (slot == table_.kNone && !mask.any()) return;
        if (slot == table_.kNone) slot = table_.findOrInsert(key, kEmpty);
        const bool needsMask = mask.any() && !mask.all();
        if (needsMask) {
            if (!hasOwnMask(slot)) table_.assign(key, slot = masks_.allocate() + kFirstMask);
            masks_[slot - kFirstMask] = mask;
        } else {
            if (hasOwnMask(slot)) masks_.release(slot - kFirstMask);
            table_.assign(key, mask.any() ? kFull : kEmpty);
        }
    }

    void swap(SaturatedBlocks& o) {
        clamp.swap(o.clamp);
        std::swap(table_, o.table_);
        std::swap(masks_, o.masks_);
    }

    void clear() {
        table_.clear();
        masks_.clear();
    }

    std::size_t memoryBytes() const { return table_.memoryBytes() + masks_.memoryBytes(); }

 private:
    static constexpr std::uint32_t kFull = 0, kEmpty = 1, kFirstMask = 2;
    static bool hasOwnMask(std::uint32_t slot) {
        return slot != BlockTable<Dim>::kNone && slot >= kFirstMask;
    }

    BlockTable<Dim> table_;
    ChunkedPool<BlockMask<Dim>, 64> masks_;
};

}  // namespace superray
