#pragma once
/// \file saturation_cache.h
/// Which cells of recently written blocks of a tree are saturated free.

#include <superray/core/scan_integrator.h>

#include "block_table.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace superray {

/// Reading these off the nodes takes microseconds a block, so what a scan has
/// written is kept for the next ones. Two generations: when the younger one is
/// full, it takes the place of the older one. Not part of the map's contents.
template <int Dim>
class SaturationCache {
 public:
    /// nullptr: not kept. Valid until the next put()
    const BlockSaturation<Dim>* find(const BlockKey<Dim>& key, float lowerClamp) const {
        if (lowerClamp != clamp_) return nullptr;
        const BlockSaturation<Dim>* const found = young_.find(key);
        return found != nullptr ? found : old_.find(key);
    }

    /// \param room entries of a generation, at least
    void use(float lowerClamp, std::size_t room) {
        if (lowerClamp != clamp_) clear();
        clamp_ = lowerClamp;
        room_ = std::max(room, kLeastRoom);
    }
    /// \pre use() was called
    void put(const BlockKey<Dim>& key, const BlockSaturation<Dim>& saturation) {
        if (young_.entries.size() >= room_) {
            std::swap(young_, old_);
            young_.clear();
        }
        young_.put(key, saturation);
    }
    float clamp() const { return clamp_; }

    void clear() {
        young_.clear();
        old_.clear();
        clamp_ = std::numeric_limits<float>::quiet_NaN();
    }

 private:
    static constexpr std::size_t kLeastRoom = 1024;

    struct Generation {
        BlockTable<Dim> table;
        std::vector<BlockSaturation<Dim>> entries;

        const BlockSaturation<Dim>* find(const BlockKey<Dim>& key) const {
            const std::uint32_t slot = table.find(key);
            return slot == BlockTable<Dim>::kNone ? nullptr : &entries[slot];
        }
        void put(const BlockKey<Dim>& key, const BlockSaturation<Dim>& saturation) {
            const auto next = static_cast<std::uint32_t>(entries.size());
            const std::uint32_t slot = table.findOrInsert(key, next);
            if (slot == next)
                entries.push_back(saturation);
            else
                entries[slot] = saturation;
        }
        void clear() {
            table.clear();
            entries.clear();
        }
    };

    Generation young_, old_;
    float clamp_ = std::numeric_limits<float>::quiet_NaN();
    std::size_t room_ = kLeastRoom;
};

}  // namespace superray
