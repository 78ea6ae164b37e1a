// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file block_table.h
/// Table from block key to a small value: pages of neighbouring blocks, hashed.

#include <superray/core/detail/linear_probing.h>

#include "values/value_rules.h"

#include <algorithm>
#include <vector>

namespace superray {

/// Scans ask for neighbouring blocks, so these are kept in one page of 64, a few
/// cache lines. Pages are found by open addressing with linear probing. A page has values
/// of all its blocks, default ones of those that nobody has set.
template <int Dim, typename Value>
class BlockTable {
 public:
    /// Where a value is. Stays the same, while references are good until a page is made.
    using Place = std::size_t;
    static constexpr Place kNowhere = ~Place{0};

    std::size_t memoryBytes() const {
        return pages_.capacity() * sizeof(Entry) + values_.capacity() * sizeof(Value) +
               freePages_.capacity() * sizeof(freePages_[0]);
    }

    /// The most that memoryBytes() can be after so many pages were made.
    std::size_t memoryBytesAtMost(std::size_t pages) const {
        const std::size_t made = pages - std::min(pages, freePages_.size());
        std::size_t slots = pages_.size();
        while (4 * (pageCount() + made + 1) > 3 * slots) slots = slots == 0 ? 16 : 2 * slots;
        const std::size_t values = (pageCount() + made) * kPageBlocks;
        return (slots > pages_.size() ? slots : pages_.capacity()) * sizeof(Entry) +
               (values > values_.capacity() ? 2 * values : values_.capacity()) * sizeof(Value) +
               freePages_.capacity() * sizeof(freePages_[0]);
    }

    void clear() { *this = BlockTable(); }

    /// Where the value of a key is; kNowhere if there is no page with it (also for keys
    /// out of the addressable range).
    Place find(const BlockKey<Dim>& key) const {
        if (pages_.empty() || !isAddressable(key, kBlockLimit)) return kNowhere;
        const Entry& page = pages_[position(pageOf(key))];
        return page.key == kFree ? kNowhere : placeIn(page, key);
    }

    /// The same, but a page that is missing is made. \pre the key is addressable
    Place findOrMake(const BlockKey<Dim>& key) {
        if (4 * (pageCount() + 1) > 3 * pages_.size()) grow();
        Entry& page = pages_[position(pageOf(key))];
        if (page.key == kFree) {
            page = {pageOf(key), takePage()};
        }
        return placeIn(page, key);
    }

    /// So that values of so many bytes can be made without asking the system.
    void reserve(std::size_t bytes) {
        const std::size_t values = values_.size();
        values_.resize(values + bytes / sizeof(Value));  // touches them
        values_.resize(values);
    }

    Value& operator[](Place place) { return values_[place]; }
    const Value& operator[](Place place) const { return values_[place]; }

    /// visit(key, value) for every value of every page, in unspecified order.
    template <typename Visit>
    void forEach(Visit&& visit) const {
        for (const Entry& page : pages_) {
            if (page.key == kFree) continue;
            for (std::uint32_t i = 0; i < kPageBlocks; ++i)
                visit(keyOf(page.key, i), values_[page.number * Place{kPageBlocks} + i]);
        }
    }
    /// A number that all blocks of a page have in common, and no others.
    static std::uint64_t pageOf(const BlockKey<Dim>& key) {
        std::uint64_t p = 0;
        for (int a = Dim - 1; a >= 0; --a)
            p = (p << kAxisBits) |
                static_cast<std::uint32_t>(key[a] + kBlockLimit) >> kPageBits;
        return p;
    }
    static constexpr std::uint64_t kNoPage = ~std::uint64_t{0};  ///< no page has it
    /// The key that blocks of one page have in common: that of the page's lowest block.
    static BlockKey<Dim> pageKey(const BlockKey<Dim>& key) { return keyOf(pageOf(key), 0); }
    /// Visits the pages in unspecified order: visit(lowest key, highest key, page).
    template <typename Visit>
    void forEachPage(Visit&& visit) const {
        for (const Entry& page : pages_)
            if (page.key != kFree)
                visit(keyOf(page.key, 0), keyOf(page.key, kPageBlocks - 1), page.key);
    }
    /// visit(key, place) for every value of a page.
    template <typename Visit>
    void forEachPlace(std::uint64_t page, Visit&& visit) const {
        const Place first = pages_[position(page)].number * Place{kPageBlocks};
        for (std::uint32_t i = 0; i < kPageBlocks; ++i) visit(keyOf(page, i), first + i);
    }
    /// The next page that is made takes the memory of this one. Places in other pages stay
    /// the same. \pre all values of the page are default ones  \throws std::bad_alloc
    void removePage(std::uint64_t page) {
        const std::size_t at = position(page);
        freePages_.push_back(pages_[at].number);
        detail::emptySlot(
            pages_, at, [](const Entry& e) { return e.key == kFree; },
            [&](const Entry& e) { return home(e.key); });
    }
    /// All of them, without keys.
    const std::vector<Value>& values() const { return values_; }

 private:
    static constexpr int kPageBits = 6 / Dim;  // blocks per axis and page: 4 (in 2D, 8)
    static constexpr std::uint32_t kPageBlocks = 1u << (kPageBits * Dim);
    static constexpr int kAxisBits = 13 - kPageBits;  // of a page's key
    static_assert(1 << (kAxisBits + kPageBits) == 2 * kBlockLimit && kAxisBits * Dim < 64);
    static constexpr std::uint64_t kFree = kNoPage;

    struct Entry {
        std::uint64_t key = kFree;
        std::uint32_t number = 0;
    };

    /// Removed ones included.
    std::size_t pageCount() const { return values_.size() / kPageBlocks; }

    static Place placeIn(const Entry& page, const BlockKey<Dim>& key) {
        Place i = page.number;
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

    /// Number of a page of default values.
    std::uint32_t takePage() {
        if (!freePages_.empty()) {
            const std::uint32_t number = freePages_.back();
            freePages_.pop_back();
            return number;
        }
        const std::size_t number = pageCount();
        values_.resize(values_.size() + kPageBlocks);
        return static_cast<std::uint32_t>(number);
    }

    /// Where a page goes if nothing is there.
    std::size_t home(std::uint64_t page) const {
        std::uint64_t h = page * 0x9E3779B97F4A7C15ull;
        h = (h ^ (h >> 32)) * 0xD6E8FEB86659FD93ull;
        return static_cast<std::size_t>(h >> 32) & (pages_.size() - 1);
    }
    /// Where the page is, or where it would go.
    std::size_t position(std::uint64_t page) const {
        const std::size_t mask = pages_.size() - 1;
        std::size_t i = home(page);
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
    std::vector<Value> values_;
    std::vector<std::uint32_t> freePages_;  // numbers of removed pages, all values default
};

}  // namespace superray
