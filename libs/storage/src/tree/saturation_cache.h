// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file saturation_cache.h
/// Which cells of recently written blocks of a tree are saturated free.

#include <superray/core/saturation_source.h>

#include "containers/block_table.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

namespace superray {

/// Reading these off the nodes takes microseconds a block, so what a scan has
/// written is kept for the next ones. Two generations: when the younger one is
/// full, it takes the place of the older one. Not part of the map's contents.
template <int Dim>
class SaturationCache {
 public:
    /// nothing: not kept
    std::optional<BlockSaturation<Dim>> find(const BlockKey<Dim>& key, float lowerClamp) const {
        if (lowerClamp != clamp_) return std::nullopt;
        if (const auto found = young_.find(key)) return found;
        return old_.find(key);
    }

    /// Before the blocks of a scan are written. Until all entries that it asks
    /// for are put, nothing is kept for good: clear() if that fails.
    void startScan(float lowerClamp, std::size_t blocks) {
        if (lowerClamp != clamp_) clear();
        clamp_ = lowerClamp;
        // Two scans a generation.
        const std::size_t room = std::max(2 * blocks, kLeastRoom);
        if (young_.entries.size() + blocks <= room) return;
        std::swap(young_, old_);
        young_.clear();
    }
    /// The entry of a block, for get() and put(), which several threads may
    /// call for different entries. \pre startScan()
    std::uint32_t entryOf(const BlockKey<Dim>& key) { return young_.entryOf(key); }
    std::optional<BlockSaturation<Dim>> get(const BlockKey<Dim>& key,
                                            std::uint32_t entry) const {
        const Entry& e = young_.entries[entry];
        return e.known ? e.saturation() : old_.find(key);
    }
    void put(std::uint32_t entry, const BlockSaturation<Dim>& s) {
        young_.entries[entry] = {s.saturatedFree, s.mayExceedUnknown, true};
    }
    /// The cells of a block are unknown now.
    void forget(const BlockKey<Dim>& key) {
        for (Generation* generation : {&young_, &old_})
            if (Entry* const entry = generation->entry(key)) entry->known = false;
    }
    float clamp() const { return clamp_; }

    void clear() {
        young_.clear();
        old_.clear();
        clamp_ = std::numeric_limits<float>::quiet_NaN();
    }

 private:
    static constexpr std::size_t kLeastRoom = 1024;

    struct Entry {
        BlockMask<Dim> saturatedFree;
        bool mayExceedUnknown = false;
        bool known = false;
        BlockSaturation<Dim> saturation() const { return {saturatedFree, mayExceedUnknown}; }
    };
    struct Generation {
        static constexpr std::uint32_t kNone = ~std::uint32_t{0};
        struct Number {
            std::uint32_t value = kNone;
        };
        BlockTable<Dim, Number> table;  // of entries
        std::vector<Entry> entries;

        std::optional<BlockSaturation<Dim>> find(const BlockKey<Dim>& key) const {
            const auto place = table.find(key);
            if (place == table.kNowhere) return std::nullopt;
            const std::uint32_t number = table[place].value;
            if (number == kNone || !entries[number].known) return std::nullopt;
            return entries[number].saturation();
        }
        /// nullptr: there is none
        Entry* entry(const BlockKey<Dim>& key) {
            const auto place = table.find(key);
            if (place == table.kNowhere || table[place].value == kNone) return nullptr;
            return &entries[table[place].value];
        }
        std::uint32_t entryOf(const BlockKey<Dim>& key) {
            std::uint32_t& number = table[table.findOrMake(key)].value;
            if (number == kNone) {
                entries.emplace_back();
                number = static_cast<std::uint32_t>(entries.size() - 1);
            }
            return number;
        }
        void clear() {
            table.clear();
            entries.clear();
        }
    };

    Generation young_, old_;
    float clamp_ = std::numeric_limits<float>::quiet_NaN();
};

}  // namespace superray
