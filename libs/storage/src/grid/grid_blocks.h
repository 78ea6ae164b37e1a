// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The blocks of a block grid: where they are, and what is in them.

#include <superray/storage/occupancy_map.h>

#include "containers/block_table.h"
#include "containers/chunked_pool.h"
#include "grid/block_parts.h"
#include "values/fold_layers.h"
#include "values/saturation_clamp.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace superray::grid {

/// All blocks of a grid.
template <int Dim>
struct Blocks {
    using Table = BlockTable<Dim, Block>;
    using Place = typename Table::Place;
    Table table;
    std::size_t count = 0;  ///< of blocks that are not absent
    ChunkedPool<Payload<Dim>, 64> payloads;
    ChunkedPool<Layer, 64> layers;
    SaturationClamp clamp;

    const Block* find(const BlockKey<Dim>& key) const { return at(table.find(key)); }
    Block* find(const BlockKey<Dim>& key) {
        return const_cast<Block*>(std::as_const(*this).find(key));
    }
    /// The block there, unless it is absent.
    const Block* at(Place place) const {
        if (place == Table::kNowhere || table[place].payload == kAbsent) return nullptr;
        return &table[place];
    }
    /// A block, which gets a payload without known cells if it is absent.
    Block& findOrAdd(const BlockKey<Dim>& key) {
        const Place place = table.findOrMake(key);
        if (table[place].payload == kAbsent) payloads[add(place)] = Payload<Dim>{};
        return table[place];
    }

    /// Gives an absent block a payload of unspecified contents: its number.
    std::uint32_t add(Place place) {
        const std::uint32_t payload = payloads.allocate();
        table[place].payload = payload;
        ++count;
        return payload;
    }

    /// Payload of a block, made from its uniform value if it has none.
    Payload<Dim>& expand(Block& block) {
        if (block.payload == kUniform) {
            const std::uint32_t fresh = payloads.allocate();
            Payload<Dim>& p = payloads[fresh] = Payload<Dim>{};
            for (auto& layer : p.layers) {
                layer = layers.allocate();
                layers[layer].values.fill(block.highest);
            }
            p.known = fullMask<Dim>();
            if (clamp.isAt(block.highest)) p.saturated = p.known;
            block.payload = fresh;
        }
        return payloads[block.payload];
    }

    /// Values of layer z, made (all unknown) if there are none.
    float* layer(Payload<Dim>& p, int z) {
        auto& layer = p.layers[z];
        if (layer == kNoLayer) {
            layer = layers.allocate();
            layers[layer].values.fill(0.0f);
        }
        return layers[layer].values.data();
    }

    /// Value of a known cell.
    float value(const Payload<Dim>& p, int index) const {
        return layers[p.layers[index >> 6]].values[index & 63];
    }

    /// Memory for blocks to come, of so many bytes in all.
    void reserve(std::size_t bytes) {
        // What a block takes outdoors: half of its layers, and with its neighbours that
        // are absent, values of three in the table.
        constexpr std::size_t kTable = 3 * sizeof(Block), kPayload = sizeof(Payload<Dim>),
                              kLayers = (Payload<Dim>::kLayers + 1) / 2 * sizeof(Layer);
        const std::size_t blocks = bytes / (kTable + kPayload + kLayers);
        table.reserve(blocks * kTable);
        payloads.reserve(blocks * kPayload);
        layers.reserve(blocks * kLayers);
    }

    /// \param values scratch memory
    void visit(const BlockKey<Dim>& key, const Block& block,
               std::array<float, kBlockCells<Dim>>& values,
               const typename OccupancyMap<Dim>::BlockVisitor& visitor) const {
        if (block.payload == kUniform) {
            values.fill(block.highest);
            visitor({key, values.data(), fullMask<Dim>()});
            return;
        }
        const Payload<Dim>& p = payloads[block.payload];
        for (int z = 0; z < Payload<Dim>::kLayers; ++z)
            if (p.layers[z] != kNoLayer)
                std::copy_n(layers[p.layers[z]].values.data(), 64, values.data() + 64 * z);
        visitor({key, values.data(), p.known});
    }

    bool isUniform(const Payload<Dim>& p) const {
        if (!p.known.all()) return false;
        // Values have no NaN and no -0, so equal values have equal bits.
        const float first = value(p, 0);
        return std::all_of(p.layers.begin(), p.layers.end(), [&](std::uint32_t layer) {
            const auto& values = layers[layer].values;
            return std::all_of(values.begin(), values.end(),
                               [&](float v) { return v == first; });
        });
    }

    /// Asks the memory for what findFor() will read of a block.
    void fetch(Place place) const {
        const Block* const block = at(place);
        if (block == nullptr || block->payload == kUniform) return;
        const auto* const payload = reinterpret_cast<const char*>(&payloads[block->payload]);
        for (std::size_t i = 0; i < sizeof(Payload<Dim>); i += 64)
            __builtin_prefetch(payload + i);
    }

    /// Finds what the touched cells of a block need. Makes nothing, so threads may do
    /// this at once. \pre p.touched and p.place are set
    /// \param hits of the block's cells, nullptr for none
    /// \return false if something is missing
    bool findFor(Pending<Dim>& p, const std::uint8_t* hits, const FoldVersion& fold) {
        p.payload = nullptr;
        p.fresh = 0;
        p.freshPayload = false;
        if (!p.touched.any()) return true;
        if (at(p.place) == nullptr) return false;
        Block& block = table[p.place];
        if (block.payload == kUniform)  // saturated free: misses change nothing
            return clamp.isAt(block.highest) && hits == nullptr;
        Payload<Dim>& payload = payloads[block.payload];
        leaveOutSaturated<Dim>(fold, p.touched, payload.saturated, hits);
        if (!p.touched.any()) return true;
        p.payload = &payload;
        if (hits != nullptr) block.highest = kAnyLogOdds;
        bool all = true;
        for (int z = 0; z < Payload<Dim>::kLayers; ++z) {
            p.values[z] = nullptr;
            if (p.touched.words[z] == 0) continue;
            if (p.payload->layers[z] == kNoLayer)
                all = false;
            else
                p.values[z] = layers[p.payload->layers[z]].values.data();
        }
        return all;
    }

    /// Makes what findFor() missed. Its contents are left to p.fillIn().
    /// \pre there is room for it
    void makeFor(Pending<Dim>& p, const BlockKey<Dim>& key, bool hit) {
        if (p.payload == nullptr) {
            p.values.fill(nullptr);
            p.place = table.findOrMake(key);
            if (table[p.place].payload == kAbsent) {
                p.payload = &payloads[add(p.place)];
                p.freshPayload = true;
            } else {
                p.payload = &expand(table[p.place]);
                for (int z = 0; z < Payload<Dim>::kLayers; ++z)
                    p.values[z] = layers[p.payload->layers[z]].values.data();
            }
            if (hit) table[p.place].highest = kAnyLogOdds;
        }
        for (int z = 0; z < Payload<Dim>::kLayers; ++z) {
            if (p.touched.words[z] == 0 || p.values[z] != nullptr) continue;
            p.made[z] = layers.allocate();
            p.values[z] = layers[p.made[z]].values.data();
            p.fresh |= 1u << z;
        }
    }

    /// Gives the payload back if the block has become uniform.
    void collapse(Block& block) {
        const Payload<Dim>& p = payloads[block.payload];
        if (!isUniform(p)) return;
        block.highest = value(p, 0);
        for (const std::uint32_t layer : p.layers) layers.release(layer);
        payloads.release(block.payload);
        block.payload = kUniform;
    }

    /// Makes all cells of a block unknown. \pre it is not absent
    void forget(Block& block) {
        if (block.payload != kUniform) {
            for (const std::uint32_t layer : payloads[block.payload].layers)
                if (layer != kNoLayer) layers.release(layer);
            payloads.release(block.payload);
        }
        block = {};
        --count;
    }

    void forgetOutside(const BlockWindow<Dim>& window,
                       const typename OccupancyMap<Dim>::KeyVisitor& forgotten) {
        using Overlap = typename BlockWindow<Dim>::Overlap;
        std::vector<std::uint64_t> pages;
        table.forEachPage(
            [&](const BlockKey<Dim>& lowest, const BlockKey<Dim>& highest, std::uint64_t page) {
                if (window.overlap(lowest, highest) != Overlap::whole) pages.push_back(page);
            });
        for (const std::uint64_t page : pages) {
            bool empty = true;
            table.forEachPlace(page, [&](const BlockKey<Dim>& key, Place place) {
                if (table[place].payload == kAbsent) return;
                if (window.holds(key)) {
                    empty = false;
                } else {
                    forget(table[place]);
                    forgotten(key);
                }
            });
            if (empty) table.removePage(page);
        }
    }

    void rebuildSaturation(float lowerClamp) {
        for (const Block& block : table.values()) {
            if (block.payload == kUniform || block.payload == kAbsent) continue;
            Payload<Dim>& p = payloads[block.payload];
            p.saturated = {};
            for (int i = 0; i < kBlockCells<Dim>; ++i)
                if (p.known.test(i) && value(p, i) == lowerClamp) p.saturated.set(i);
        }
    }

    void useClamp(float lowerClamp) {
        clamp.use(lowerClamp, [&] { rebuildSaturation(lowerClamp); });
    }

    void set(Block& block, int index, float newValue) {
        Payload<Dim>& p = expand(block);
        layer(p, index >> 6)[index & 63] = newValue;
        p.known.set(index);
        block.highest = std::max(block.highest, newValue);
        if (clamp.isAt(newValue))
            p.saturated.set(index);
        else
            p.saturated.reset(index);
    }
};

}  // namespace superray::grid
