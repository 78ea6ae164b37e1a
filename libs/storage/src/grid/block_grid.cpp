// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/detail/parallel.h>
#include <superray/storage/block_grid.h>

#include "grid/grid_blocks.h"
#include "grid/grid_growth.h"
#include "values/fold_layers.h"

#include <algorithm>

namespace superray {
namespace {

using grid::Block;
using grid::kAbsent;
using grid::kUniform;
using grid::Payload;
using grid::Pending;

/// Blocks that repay a thread, and that one thread makes before it folds them.
constexpr std::size_t kBlocksPerChunk = 512, kBlocksAtOnce = 16;
/// Blocks that a thread folds before others may be made: what it has found of them stays
/// in the cache, and waiting for the other threads takes little in comparison.
constexpr std::size_t kBlocksOfThread = 1 << 10;

}  // namespace

template <int Dim>
struct BlockGrid<Dim>::Impl : grid::Blocks<Dim> {
    // Scratch of apply():
    std::vector<Pending<Dim>> pending;
    /// Numbers of blocks that a chunk has left to do for one thread.
    struct Left {
        std::vector<std::size_t> toMake, toCollapse;
    };
    std::vector<Left> left;

    /// Takes the memory for it. \throws std::bad_alloc
    void prepareScratch(std::size_t blocks, std::size_t chunks, std::size_t step) {
        pending.resize(std::min(blocks, step));
        left.resize(std::max(chunks, left.size()));
        for (Left& l : left) {
            l.toMake.reserve(step / chunks + 1);
            l.toCollapse.reserve(step / chunks + 1);
        }
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
    this->swapValueRange(o);
}

template <int Dim>
void BlockGrid<Dim>::apply(const UpdateBatch<Dim>& batch, const SensorModel& model,
                           UpdatePolicy policy, unsigned threads) {
    threads = this->beginUpdate(batch, model, policy, threads);
    const std::size_t chunks = chunkCountFor(batch.blockCount(), kBlocksPerChunk, threads);
    // New blocks and layers get their numbers from one thread, some blocks ahead of the
    // folding, so that what it has just read is still in the cache.
    const std::size_t step = chunks == 1 ? kBlocksAtOnce : chunks * kBlocksOfThread;
    impl_->prepareScratch(batch.blockCount(), chunks, step);
    grid::makePages<Dim>(*impl_, batch);
    // Nothing fails from here on.

    impl_->useClamp(model.min());
    const FoldModel foldModel(model, policy);
    const FoldVersion& fold = foldForThisCpu();
    std::vector<typename Impl::Left>& left = impl_->left;
    for (std::size_t first = 0; first < batch.blockCount(); first += step) {
        const std::size_t last = std::min(batch.blockCount(), first + step);
        // Calls each work for some blocks, then the next one for them.
        const auto forShare = [&](std::size_t chunk, const auto&... works) {
            const std::size_t n = last - first;
            const std::size_t end = chunkBegin(n, chunk + 1, chunks);
            for (std::size_t i = chunkBegin(n, chunk, chunks); i < end; i += kBlocksAtOnce) {
                const std::size_t some = std::min(end, i + kBlocksAtOnce);
                const auto forSome = [&](const auto& work) {
                    for (std::size_t j = i; j < some; ++j) work(impl_->pending[j], first + j);
                };
                (forSome(works), ...);
            }
        };
        inParallel(chunks, [&](std::size_t chunk) {
            left[chunk].toMake.clear();
            // What is needed of a block arrives while others are looked up.
            forShare(
                chunk,
                [&](Pending<Dim>& p, std::size_t b) {
                    p.place = impl_->table.find(batch.key(b));
                    if (p.place != impl_->table.kNowhere)
                        __builtin_prefetch(&impl_->table[p.place]);
                },
                [&](Pending<Dim>& p, std::size_t) { impl_->fetch(p.place); },
                [&](Pending<Dim>& p, std::size_t b) {
                    fold.touchedCells(Payload<Dim>::kLayers, batch.misses(b), batch.hits(b),
                                      p.touched.words.data());
                    if (!impl_->findFor(p, batch.hits(b), fold))
                        left[chunk].toMake.push_back(b);
                });
        });
        for (std::size_t chunk = 0; chunk < chunks; ++chunk)
            for (const std::size_t b : left[chunk].toMake)
                impl_->makeFor(impl_->pending[b - first], batch.key(b),
                               batch.hits(b) != nullptr);
        inParallel(chunks, [&](std::size_t chunk) {
            left[chunk].toCollapse.clear();
            forShare(chunk, [&](Pending<Dim>& p, std::size_t block) {
                if (p.payload == nullptr) return;
                p.fillIn();
                fold.foldCounts(
                    foldModel,
                    {Payload<Dim>::kLayers, p.values.data(), p.touched.words.data(),
                     p.payload->known.words.data(), p.payload->saturated.words.data()},
                    batch.misses(block), batch.hits(block));
                if (impl_->isUniform(*p.payload)) left[chunk].toCollapse.push_back(block);
            });
        });
        for (std::size_t chunk = 0; chunk < chunks; ++chunk)
            for (const std::size_t b : left[chunk].toCollapse)
                impl_->collapse(impl_->table[impl_->pending[b - first].place]);
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
    this->noteValue(value);
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
    this->noteValues(view);
    Block& block = impl_->findOrAdd(view.key);
    for (int i = 0; i < kBlockCells<Dim>; ++i)
        if (view.known.test(i)) impl_->set(block, i, values[i]);
    impl_->collapse(block);
}

template <int Dim>
void BlockGrid<Dim>::forEachBlock(const typename OccupancyMap<Dim>::BlockVisitor& visit) const {
    std::array<float, kBlockCells<Dim>> values{};
    impl_->table.forEach([&](const BlockKey<Dim>& key, const Block& block) {
        if (block.payload != kAbsent) impl_->visit(key, block, values, visit);
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
    this->noteCleared();
}

template <int Dim>
bool BlockGrid<Dim>::empty() const {
    return impl_->count == 0;
}

template <int Dim>
void BlockGrid<Dim>::reserve(std::size_t bytes) {
    impl_->reserve(bytes);
}

template <int Dim>
std::size_t BlockGrid<Dim>::memoryBytes() const {
    return sizeof(Impl) + impl_->table.memoryBytes() + impl_->payloads.memoryBytes() +
           impl_->layers.memoryBytes();
}

template <int Dim>
void BlockGrid<Dim>::forgetOutside(const BlockWindow<Dim>& window,
                                   const typename OccupancyMap<Dim>::KeyVisitor& forgotten) {
    impl_->forgetOutside(window, forgotten);
}

template <int Dim>
std::size_t BlockGrid<Dim>::heldBytes() const {
    return memoryBytes();
}

template <int Dim>
std::size_t BlockGrid<Dim>::heldBytesAtMost(std::size_t blocks, unsigned) const {
    return sizeof(Impl) + grid::memoryBytesAtMost<Dim>(*impl_, grid::growthAtMost<Dim>(blocks));
}

template <int Dim>
std::size_t BlockGrid<Dim>::heldBytesWith(
    const typename OccupancyMap<Dim>::WrittenBlocks& written) const {
    return sizeof(Impl) +
           grid::memoryBytesAtMost<Dim>(*impl_, grid::growthBy<Dim>(*impl_, written));
}

template <int Dim>
void BlockGrid<Dim>::keepRoomFor(std::size_t blocks, unsigned /*threads*/) {
    grid::keepRoom<Dim>(*impl_, grid::growthAtMost<Dim>(blocks));
}

template <int Dim>
void BlockGrid<Dim>::keepRoomFor(const typename OccupancyMap<Dim>::WrittenBlocks& written) {
    written([&](const BlockView<Dim>& block) { impl_->table.findOrMake(block.key); });
    grid::keepRoom<Dim>(*impl_, grid::growthBy<Dim>(*impl_, written));
}

template <int Dim>
BlockSaturation<Dim> BlockGrid<Dim>::saturation(const BlockKey<Dim>& key,
                                                float lowerClamp) const {
    BlockSaturation<Dim> result;
    const auto place = impl_->table.find(key);
    if (place == impl_->table.kNowhere) return result;
    const Block* block = impl_->at(place);
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
