#pragma once
// The blocks of a block grid: where they are, and what is in them.

#include <superray/storage/occupancy_map.h>

#include "block_table.h"
#include "chunked_pool.h"
#include "saturation_clamp.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

namespace superray::grid {

/// Values of 64 cells (one BlockMask word), 0 where not known.
struct alignas(64) Layer {
    std::array<float, 64> values;
};
inline constexpr std::uint32_t kNoLayer = ~std::uint32_t{0};

/// A block that is not uniform. Layers without known cells take no memory.
template <int Dim>
struct alignas(64) Payload {
    static constexpr int kLayers = BlockMask<Dim>::kWords;
    Payload() { layers.fill(kNoLayer); }
    BlockMask<Dim> saturated;  // known cells at the lower clamp; asked for most
    BlockMask<Dim> known;
    std::array<std::uint32_t, kLayers> layers;
};

inline constexpr std::uint32_t kUniform = ~std::uint32_t{0};

/// A block is uniform (all cells known, one value) or has a payload.
struct Block {
    std::uint32_t payload = kUniform;
    float highest = 0;  ///< the one value; else no cell has log-odds above it
};
inline constexpr float kAnyLogOdds = std::numeric_limits<float>::infinity();

/// A block of a batch on its way into the map.
template <int Dim>
struct Pending {
    BlockMask<Dim> touched;
    Block* block;           ///< until blocks are made
    Payload<Dim>* payload;  ///< nullptr: nothing to do
    std::array<float*, Payload<Dim>::kLayers> values;
    std::uint32_t fresh;  ///< bit z: layer z is new and its values unspecified
    bool found;           ///< the map had all that is needed
    bool uniform;

    /// Makes all cells of new layers 0, as unknown ones are.
    void clear() {
        for (int z = 0; payload != nullptr && z < Payload<Dim>::kLayers; ++z)
            if (fresh >> z & 1) std::fill_n(values[z], 64, 0.0f);
    }
};

/// All blocks of a grid.
template <int Dim>
struct Blocks {
    BlockTable<Dim> table;
    std::vector<Block> blocks;
    ChunkedPool<Payload<Dim>, 64> payloads;
    ChunkedPool<Layer, 64> layers;
    SaturationClamp clamp;

    const Block* find(const BlockKey<Dim>& key) const {
        const std::uint32_t slot = table.find(key);
        return slot == BlockTable<Dim>::kNone ? nullptr : &blocks[slot];
    }
    Block* find(const BlockKey<Dim>& key) {
        return const_cast<Block*>(std::as_const(*this).find(key));
    }
    Block& findOrAdd(const BlockKey<Dim>& key) {
        Block* block = find(key);
        return block ? *block : add(key);
    }

    /// A new block without known cells. \pre there is none of this key
    Block& add(const BlockKey<Dim>& key) {
        // What may throw comes first, so that a failure leaves the map whole.
        if (blocks.size() == blocks.capacity()) blocks.reserve(blocks.size() * 2 + 16);
        const std::uint32_t payload = payloads.allocate();
        payloads[payload] = Payload<Dim>{};
        table.findOrInsert(key, static_cast<std::uint32_t>(blocks.size()));
        blocks.push_back({payload, 0.0f});
        return blocks.back();
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
    void fetch(const Block& block) const {
        if (block.payload == kUniform) return;
        const auto* const payload = reinterpret_cast<const char*>(&payloads[block.payload]);
        for (std::size_t at = 0; at < sizeof(Payload<Dim>); at += 64)
            __builtin_prefetch(payload + at);
    }

    /// Finds what the touched cells of a block need. Makes nothing, so threads may do
    /// this at once. \pre p.touched is set; p.block is the map's, or nullptr
    /// \return false if something is missing
    bool findFor(Pending<Dim>& p, bool hit) {
        p.payload = nullptr;
        p.fresh = 0;
        if (!p.touched.any()) return true;
        Block* const block = p.block;
        if (block == nullptr) return false;
        if (block->payload == kUniform)  // saturated free: misses change nothing
            return clamp.isAt(block->highest) && !hit;
        Payload<Dim>& payload = payloads[block->payload];
        for (int z = 0; z < Payload<Dim>::kLayers; ++z) {
            p.values[z] = nullptr;
            if (p.touched.words[z] == 0) continue;
            if (payload.layers[z] == kNoLayer) return false;
            p.values[z] = layers[payload.layers[z]].values.data();
        }
        if (hit) block->highest = kAnyLogOdds;
        p.payload = &payload;
        return true;
    }

    /// Makes what findFor() missed.
    void makeFor(Pending<Dim>& p, const BlockKey<Dim>& key, bool hit) {
        Block* block = find(key);
        if (block == nullptr) block = &add(key);
        Payload<Dim>& payload = expand(*block);
        if (hit) block->highest = kAnyLogOdds;
        p.payload = &payload;
        for (int z = 0; z < Payload<Dim>::kLayers; ++z) {
            p.values[z] = nullptr;
            if (p.touched.words[z] == 0) continue;
            if (payload.layers[z] == kNoLayer) {
                const std::uint32_t layer = layers.allocate();
                payload.layers[z] = layer;
                p.fresh |= 1u << z;
            }
            p.values[z] = layers[payload.layers[z]].values.data();
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

    void rebuildSaturation(float lowerClamp) {
        for (const Block& block : blocks) {
            if (block.payload == kUniform) continue;
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
