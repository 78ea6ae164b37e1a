#include <superray/core/parallel.h>
#include <superray/storage/block_grid.h>

#include "block_table.h"
#include "chunked_pool.h"
#include "fold_layers.h"
#include "saturation_clamp.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

namespace superray {
namespace {

/// Values of 64 cells (one BlockMask word), 0 where not known.
struct alignas(64) Layer {
    std::array<float, 64> values;
};
constexpr std::uint32_t kNoLayer = ~std::uint32_t{0};

/// A block that is not uniform. Layers without known cells take no memory.
template <int Dim>
struct alignas(64) Payload {
    static constexpr int kLayers = BlockMask<Dim>::kWords;
    Payload() { layers.fill(kNoLayer); }
    BlockMask<Dim> saturated;  // known cells at the lower clamp; asked for most
    BlockMask<Dim> known;
    std::array<std::uint32_t, kLayers> layers;
};

/// Blocks that repay a thread, and that one thread makes before it folds them.
constexpr std::size_t kBlocksPerShare = 512, kBlocksAtOnce = 16;
/// Blocks that threads fold at once.
constexpr std::size_t kBlocksOfThreads = 1 << 14;

/// A block of a batch on its way into the map.
template <int Dim>
struct Pending {
    BlockMask<Dim> touched;
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

constexpr std::uint32_t kUniform = ~std::uint32_t{0};

/// A block is uniform (all cells known, one value) or has a payload.
struct Block {
    std::uint32_t payload = kUniform;
    float highest = 0;  ///< the one value; else no cell has log-odds above it
};
constexpr float kAnyLogOdds = std::numeric_limits<float>::infinity();

}  // namespace

template <int Dim>
struct BlockGrid<Dim>::Impl {
    BlockTable<Dim> table;
    std::vector<Block> blocks;
    ChunkedPool<Payload<Dim>, 64> payloads;
    ChunkedPool<Layer, 64> layers;
    SaturationClamp clamp;
    std::vector<Pending<Dim>> pending;  // scratch of apply()

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

    /// Finds what the touched cells of a block need. Makes nothing, so threads may do
    /// this at once. \pre p.touched is set
    /// \return false if something is missing
    bool findFor(Pending<Dim>& p, const BlockKey<Dim>& key, bool hit) {
        p.payload = nullptr;
        p.fresh = 0;
        if (!p.touched.any()) return true;
        Block* const block = find(key);
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

template <int Dim>
BlockGrid<Dim>::BlockGrid(const CellGeometry<Dim>& geometry)
    : OccupancyMap<Dim>(geometry), impl_(std::make_unique<Impl>()) {}
template <int Dim>
BlockGrid<Dim>::BlockGrid(const BlockGrid& o)
    : OccupancyMap<Dim>(o), impl_(std::make_unique<Impl>(*o.impl_)) {}
template <int Dim>
BlockGrid<Dim>::~BlockGrid() = default;

template <int Dim>
std::unique_ptr<OccupancyMap<Dim>> BlockGrid<Dim>::clone() const {
    return std::make_unique<BlockGrid>(*this);
}

template <int Dim>
std::unique_ptr<OccupancyMap<Dim>> BlockGrid<Dim>::emptyLike(
    const CellGeometry<Dim>& geometry) const {
    return std::make_unique<BlockGrid>(geometry);
}

template <int Dim>
void BlockGrid<Dim>::swapContents(OccupancyMap<Dim>& other) {
    auto& o = dynamic_cast<BlockGrid&>(other);
    requireSameResolution(*this, o);
    impl_.swap(o.impl_);
}

template <int Dim>
void BlockGrid<Dim>::apply(const UpdateBatch<Dim>& batch, const SensorModel& model,
                           UpdatePolicy policy, unsigned threads) {
    for (std::size_t b = 0; b < batch.blockCount(); ++b)
        requireAddressableBlock<Dim>(batch.key(b));
    impl_->useClamp(model.min());

    const FoldModel foldModel(model, policy);
    const FoldVersion& fold = foldForThisCpu();
    const std::size_t shares = std::max<std::size_t>(
        1, std::min<std::size_t>(threads, batch.blockCount() / kBlocksPerShare));
    // Blocks and layers are made by one thread, some blocks ahead of the
    // folding, so that what it has just made is still in the cache.
    const std::size_t step = shares == 1 ? kBlocksAtOnce : kBlocksOfThreads;
    for (std::size_t first = 0; first < batch.blockCount(); first += step) {
        const std::size_t last = std::min(batch.blockCount(), first + step);
        impl_->pending.resize(last - first);
        const auto forShare = [&](std::size_t share, const auto& work) {
            const std::size_t n = last - first;
            const std::size_t end = shareBegin(n, share + 1, shares);
            for (std::size_t i = shareBegin(n, share, shares); i < end; ++i)
                work(impl_->pending[i], first + i);
        };
        inParallel(shares, [&](std::size_t share) {
            forShare(share, [&](Pending<Dim>& p, std::size_t b) {
                fold.touchedCells(Payload<Dim>::kLayers, batch.misses(b), batch.hits(b),
                                  p.touched.words.data());
                p.found = impl_->findFor(p, batch.key(b), batch.hits(b) != nullptr);
            });
        });
        std::size_t b = first;
        try {
            for (; b < last; ++b)
                if (Pending<Dim>& p = impl_->pending[b - first]; !p.found)
                    impl_->makeFor(p, batch.key(b), batch.hits(b) != nullptr);
        } catch (...) {
            for (std::size_t made = first; made <= b; ++made)
                impl_->pending[made - first].clear();
            throw;
        }
        inParallel(shares, [&](std::size_t share) {
            forShare(share, [&](Pending<Dim>& p, std::size_t block) {
                if (p.payload == nullptr) return;
                p.clear();
                fold.foldCounts(
                    foldModel,
                    {Payload<Dim>::kLayers, p.values.data(), p.touched.words.data(),
                     p.payload->known.words.data(), p.payload->saturated.words.data()},
                    batch.misses(block), batch.hits(block));
                p.uniform = impl_->isUniform(*p.payload);
            });
        });
        for (b = first; b < last; ++b)
            if (const Pending<Dim>& p = impl_->pending[b - first]; p.payload && p.uniform)
                impl_->collapse(*impl_->find(batch.key(b)));
    }
}

template <int Dim>
std::optional<float> BlockGrid<Dim>::logOdds(const Cell<Dim>& cell) const {
    const Block* block = impl_->find(blockOf<Dim>(cell));
    if (!block) return std::nullopt;
    if (block->payload == kUniform) return block->highest;
    const Payload<Dim>& p = impl_->payloads[block->payload];
    const int i = indexInBlock<Dim>(cell);
    if (!p.known.test(i)) return std::nullopt;
    return impl_->value(p, i);
}

template <int Dim>
void BlockGrid<Dim>::setLogOdds(const Cell<Dim>& cell, float value) {
    requireAddressableCell<Dim>(cell);
    value = storedValue(value);
    Block& block = impl_->findOrAdd(blockOf<Dim>(cell));
    if (block.payload == kUniform && block.highest == value) return;
    impl_->set(block, indexInBlock<Dim>(cell), value);
    impl_->collapse(block);
}

template <int Dim>
void BlockGrid<Dim>::setBlock(const BlockView<Dim>& view) {
    requireAddressableBlock<Dim>(view.key);
    std::array<float, kBlockCells<Dim>> values;
    for (int i = 0; i < kBlockCells<Dim>; ++i)
        if (view.known.test(i)) values[i] = storedValue(view.values[i]);
    if (!view.known.any()) return;
    Block& block = impl_->findOrAdd(view.key);
    for (int i = 0; i < kBlockCells<Dim>; ++i)
        if (view.known.test(i)) impl_->set(block, i, values[i]);
    impl_->collapse(block);
}

template <int Dim>
void BlockGrid<Dim>::forEachBlock(const typename OccupancyMap<Dim>::BlockVisitor& visit) const {
    std::array<float, kBlockCells<Dim>> values{};
    impl_->table.forEach([&](const BlockKey<Dim>& key, std::uint32_t slot) {
        impl_->visit(key, impl_->blocks[slot], values, visit);
    });
}

template <int Dim>
bool BlockGrid<Dim>::visitBlock(const BlockKey<Dim>& key,
                                const typename OccupancyMap<Dim>::BlockVisitor& visit) const {
    const Block* block = impl_->find(key);
    if (!block) return false;
    std::array<float, kBlockCells<Dim>> values{};
    impl_->visit(key, *block, values, visit);
    return true;
}

template <int Dim>
void BlockGrid<Dim>::clear() {
    impl_ = std::make_unique<Impl>();
}

template <int Dim>
bool BlockGrid<Dim>::empty() const {
    return impl_->blocks.empty();
}

template <int Dim>
std::size_t BlockGrid<Dim>::memoryBytes() const {
    return sizeof(Impl) + impl_->table.memoryBytes() +
           impl_->blocks.capacity() * sizeof(Block) + impl_->payloads.memoryBytes() +
           impl_->layers.memoryBytes();
}

template <int Dim>
BlockSaturation<Dim> BlockGrid<Dim>::saturation(const BlockKey<Dim>& key,
                                                float lowerClamp) const {
    BlockSaturation<Dim> result;
    const Block* block = impl_->find(key);
    if (!block) return result;
    if (block->payload == kUniform) {
        if (block->highest == lowerClamp) result.saturatedFree = fullMask<Dim>();
        result.mayExceedUnknown = block->highest > 0;
        return result;
    }
    impl_->useClamp(lowerClamp);
    const Payload<Dim>& payload = impl_->payloads[block->payload];
    result.saturatedFree = payload.saturated;
    result.mayExceedUnknown = block->highest > 0;
    return result;
}

template class BlockGrid<2>;
template class BlockGrid<3>;

}  // namespace superray
