#pragma once
/// \file block_table.h
/// Hash table from block key to a 25-bit slot number, 8 bytes per entry.

#include "value_rules.h"

#include <stdexcept>
#include <vector>

namespace superray {

/// Open addressing with linear probing; entries are never removed one by one.
/// An addressable key takes 13 bits per axis, which leaves 25 for the slot.
template <int Dim>
class BlockTable {
 public:
    static constexpr std::uint32_t kSlotBits = 25;
    static constexpr std::uint32_t kNone = (1u << kSlotBits) - 1;  ///< "no such entry"
    static constexpr std::uint32_t kMaxSlot = kNone - 1;

    std::size_t size() const { return size_; }
    std::size_t memoryBytes() const { return entries_.capacity() * sizeof(Entry); }

    void clear() {
        entries_.clear();
        entries_.shrink_to_fit();
        size_ = 0;
    }

    /// Slot of a key, or kNone (also for keys out of the addressable range).
    std::uint32_t find(const BlockKey<Dim>& key) const {
        if (size_ == 0 || !isAddressable(key, kBlockLimit)) return kNone;
        return slotOf(entries_[position(pack(key))]);
    }

    /// Slot of a key, which gets `slot` if it has none.
    /// \pre the key is addressable
    /// \throws std::length_error if slot > kMaxSlot
    std::uint32_t findOrInsert(const BlockKey<Dim>& key, std::uint32_t slot) {
        if (4 * (size_ + 1) > 3 * entries_.size()) grow();
        Entry& e = entries_[position(pack(key))];
        if (e != kFree) return slotOf(e);
        if (slot > kMaxSlot) throw std::length_error("a map holds at most 2^25 - 1 blocks");
        e = (pack(key) << kSlotBits) | slot;
        ++size_;
        return slot;
    }

    /// visit(key, slot) for every entry, in unspecified order.
    template <typename Visit>
    void forEach(Visit&& visit) const {
        for (const Entry e : entries_)
            if (e != kFree) visit(unpack(e >> kSlotBits), slotOf(e));
    }

 private:
    using Entry = std::uint64_t;
    static constexpr Entry kFree = ~Entry{0};  // its slot reads kNone
    static constexpr int kAxisBits = 13;
    static_assert(1 << kAxisBits == 2 * kBlockLimit && kAxisBits * Dim + kSlotBits <= 64);

    static std::uint64_t pack(const BlockKey<Dim>& key) {
        std::uint64_t p = 0;
        for (int a = Dim - 1; a >= 0; --a)
            p = (p << kAxisBits) | static_cast<std::uint32_t>(key[a] + kBlockLimit);
        return p;
    }
    static BlockKey<Dim> unpack(std::uint64_t p) {
        BlockKey<Dim> key;
        for (auto& k : key) {
            k = static_cast<std::int32_t>(p & (2 * kBlockLimit - 1)) - kBlockLimit;
            p >>= kAxisBits;
        }
        return key;
    }
    static std::uint32_t slotOf(Entry e) { return static_cast<std::uint32_t>(e) & kNone; }

    /// Where the key is, or where it would go.
    std::size_t position(std::uint64_t packed) const {
        std::uint64_t h = packed * 0x9E3779B97F4A7C15ull;
        h = (h ^ (h >> 32)) * 0xD6E8FEB86659FD93ull;
        const std::size_t mask = entries_.size() - 1;
        std::size_t i = static_cast<std::size_t>(h >> 32) & mask;
        while (entries_[i] != kFree && entries_[i] >> kSlotBits != packed) i = (i + 1) & mask;
        return i;
    }

    void grow() {
        std::vector<Entry> old(entries_.empty() ? 16 : 2 * entries_.size(), kFree);
        old.swap(entries_);
        for (const Entry e : old)
            if (e != kFree) entries_[position(e >> kSlotBits)] = e;
    }

    std::vector<Entry> entries_;  // size 0 or a power of two
    std::size_t size_ = 0;
};

}  // namespace superray
