#pragma once
/// \file block_table.h
/// Table from block key to a slot number: pages of neighbouring blocks, hashed.

#include "value_rules.h"

#include <stdexcept>
#include <vector>

namespace superray {

/// Scans ask for neighbouring blocks, so these are kept in one page of 64, a few
/// cache lines. Pages are found by open addressing with linear probing. Entries
/// are never removed one by one.
template <int Dim>
class BlockTable {
 public:
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};  ///< "no such entry"
    static constexpr std::uint32_t kMaxSlot = kNone - 1;

    std::size_t size() const { return size_; }
    std::size_t memoryBytes() const {
        return pages_.capacity() * sizeof(Entry) + slots_.capacity() * sizeof(slots_[0]);
    }

    void clear() { *this = BlockTable(); }

    /// Slot of a key, or kNone (also for keys out of the addressable range).
    std::uint32_t find(const BlockKey<Dim>& key) const {
        if (size_ == 0 || !isAddressable(key, kBlockLimit)) return kNone;
        const Entry& page = pages_[position(pageOf(key))];
        return page.key == kFree ? kNone : slots_[slotIndex(page, key)];
    }

    /// Slot of a key, which gets `slot` if it has none.
    /// \pre the key is addressable
    /// \throws std::length_error if slot > kMaxSlot
    std::uint32_t findOrInsert(const BlockKey<Dim>& key, std::uint32_t slot) {
        if (4 * (pageCount() + 1) > 3 * pages_.size()) grow();
        Entry& page = pages_[position(pageOf(key))];
        if (page.key == kFree) {
            const std::size_t number = pageCount();
            slots_.resize(slots_.size() + kPageBlocks, kNone);
            page = {pageOf(key), static_cast<std::uint32_t>(number)};
        }
        std::uint32_t& found = slots_[slotIndex(page, key)];
        if (found != kNone) return found;
        if (slot > kMaxSlot) throw std::length_error("a map holds at most 2^32 - 1 blocks");
        found = slot;
        ++size_;
        return slot;
    }

    /// visit(key, slot) for every entry, in unspecified order.
    template <typename Visit>
    void forEach(Visit&& visit) const {
        for (const Entry& page : pages_) {
            if (page.key == kFree) continue;
            for (std::uint32_t i = 0; i < kPageBlocks; ++i)
                if (const std::uint32_t slot =
                        slots_[page.number * std::size_t{kPageBlocks} + i];
                    slot != kNone)
                    visit(keyOf(page.key, i), slot);
        }
    }

 private:
    static constexpr int kPageBits = 6 / Dim;  // blocks per axis and page: 4 (in 2D, 8)
    static constexpr std::uint32_t kPageBlocks = 1u << (kPageBits * Dim);
    static constexpr int kAxisBits = 13 - kPageBits;  // of a page's key
    static_assert(1 << (kAxisBits + kPageBits) == 2 * kBlockLimit && kAxisBits * Dim < 64);
    static constexpr std::uint64_t kFree = ~std::uint64_t{0};

    struct Entry {
        std::uint64_t key = kFree;
        std::uint32_t number = 0;
    };

    std::size_t pageCount() const { return slots_.size() / kPageBlocks; }

    static std::uint64_t pageOf(const BlockKey<Dim>& key) {
        std::uint64_t p = 0;
        for (int a = Dim - 1; a >= 0; --a)
            p = (p << kAxisBits) |
                static_cast<std::uint32_t>(key[a] + kBlockLimit) >> kPageBits;
        return p;
    }
    static std::size_t slotIndex(const Entry& page, const BlockKey<Dim>& key) {
        std::size_t i = page.number;
        for (int a = Dim - 1; a >= 0; --a)
            i = (i << kPageBits) |
                (static_cast<std::uint32_t>(key[a]) & ((1u << kPageBits) - 1));
        return i;
    }
    static BlockKey<Dim> keyOf(std::uint64_t page, std::uint32_t inPage) {
        constexpr std::uint64_t kAxis = (1u << kAxisBits) - 1;
        BlockKey<Dim> key;
        for (auto& k : key) {
            k = static_cast<std::int32_t>((page & kAxis) << kPageBits) - kBlockLimit +
                static_cast<std::int32_t>(inPage & ((1u << kPageBits) - 1));
            page >>= kAxisBits;
            inPage >>= kPageBits;
        }
        return key;
    }

    /// Where the page is, or where it would go.
    std::size_t position(std::uint64_t page) const {
        std::uint64_t h = page * 0x9E3779B97F4A7C15ull;
        h = (h ^ (h >> 32)) * 0xD6E8FEB86659FD93ull;
        const std::size_t mask = pages_.size() - 1;
        std::size_t i = static_cast<std::size_t>(h >> 32) & mask;
        while (pages_[i].key != kFree && pages_[i].key != page) i = (i + 1) & mask;
        return i;
    }

    void grow() {
        std::vector<Entry> old(pages_.empty() ? 16 : 2 * pages_.size());
        old.swap(pages_);
        for (const Entry& e : old)
            if (e.key != kFree) pages_[position(e.key)] = e;
    }

    std::vector<Entry> pages_;  // size 0 or a power of two
    std::vector<std::uint32_t> slots_;
    std::size_t size_ = 0;
};

}  // namespace superray
