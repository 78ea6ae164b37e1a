// SPDX-License-Identifier: BSD-3-Clause
// What an update writes, found without writing it.

#include <superray/storage/occupancy_map.h>

#include "values/fold_layers.h"
#include "values/value_rules.h"

#include <array>
#include <exception>
#include <unordered_map>

namespace superray {

template <int Dim>
void OccupancyMap<Dim>::forEachWritten(const UpdateBatch<Dim>& batch, const SensorModel& model,
                                       UpdatePolicy policy, const BlockVisitor& visit) const {
    constexpr int kLayers = BlockMask<Dim>::kWords;
    const FoldModel foldModel(model, policy);
    const FoldVersion& fold = foldForThisCpu();
    std::array<float, kBlockCells<Dim>> values{};
    float* layers[kLayers];
    for (int z = 0; z < kLayers; ++z) layers[z] = values.data() + 64 * z;
    for (std::size_t b = 0; b < batch.blockCount(); ++b) {
        const BlockKey<Dim>& key = batch.key(b);
        const std::uint8_t* const misses = batch.misses(b);
        const std::uint8_t* const hits = batch.hits(b);
        BlockMask<Dim> written;
        fold.touchedCells(kLayers, misses, hits, written.words.data());
        const auto saturated = this->saturation(key, model.min()).saturatedFree;
        leaveOutSaturated<Dim>(fold, written, saturated, hits);
        if (!written.any()) continue;
        values.fill(0.0f);
        visitBlock(key, [&](const BlockView<Dim>& block) {
            for (int i = 0; i < kBlockCells<Dim>; ++i)
                if (block.known.test(i)) values[static_cast<std::size_t>(i)] = block.values[i];
        });
        BlockMask<Dim> known, saturatedThen;  // not asked for
        fold.foldCounts(foldModel,
                        {kLayers, layers, written.words.data(), known.words.data(),
                         saturatedThen.words.data()},
                        misses, hits);
        visit({key, values.data(), written});
    }
}

namespace {

template <int Dim>
struct WrittenBlock {
    std::array<float, kBlockCells<Dim>> values;
    BlockMask<Dim> cells;
};

template <int Dim>
using WrittenBlockMap = std::unordered_map<BlockKey<Dim>, WrittenBlock<Dim>, IndexHash>;

template <int Dim>
WrittenBlockMap<Dim> writtenBlocks(const OccupancyMap<Dim>& map,
                                   const CellCountMap<Dim>& counts, const SensorModel& model,
                                   UpdatePolicy policy) {
    WrittenBlockMap<Dim> blocks;
    for (const auto& [cell, n] : counts) {
        if (n.misses == 0 && n.hits == 0) continue;
        const std::optional<float> before = map.logOdds(cell);
        const float after = model.updated(before.value_or(0.0f), n.misses, n.hits, policy);
        if (before && *before == after) continue;
        WrittenBlock<Dim>& block = blocks[blockOf<Dim>(cell)];
        const int i = indexInBlock<Dim>(cell);
        block.values[static_cast<std::size_t>(i)] = after;
        block.cells.set(i);
    }
    return blocks;
}

template <int Dim>
void visitAll(const WrittenBlockMap<Dim>& blocks,
              const typename OccupancyMap<Dim>::BlockVisitor& visit) {
    for (const auto& [key, block] : blocks) visit({key, block.values.data(), block.cells});
}

}  // namespace

template <int Dim>
void OccupancyMap<Dim>::forEachWritten(const CellCountMap<Dim>& counts,
                                       const SensorModel& model, UpdatePolicy policy,
                                       const BlockVisitor& visit) const {
    visitAll<Dim>(writtenBlocks(*this, counts, model, policy), visit);
}

template <int Dim>
void OccupancyMap<Dim>::apply(const CellCountMap<Dim>& counts, const SensorModel& model,
                              UpdatePolicy policy) {
    const WrittenBlockMap<Dim> blocks = writtenBlocks(*this, counts, model, policy);
    setBlocks([&](const BlockVisitor& visit) { visitAll<Dim>(blocks, visit); });
}

template <int Dim>
void OccupancyMap<Dim>::setBlocks(const WrittenBlocks& written) {
    written([](const BlockView<Dim>& block) {
        requireAddressableBlock<Dim>(block.key);
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (block.known.test(i)) storedValue(block.values[i]);
    });
    // Nothing fails after this.
    keepRoomFor(written);
    written([&](const BlockView<Dim>& block) { setBlock(block); });
}

template <int Dim>
unsigned OccupancyMap<Dim>::beginUpdate(const UpdateBatch<Dim>& batch, const SensorModel& model,
                                        UpdatePolicy policy, unsigned threads) {
    requireAddressableBlocks(batch);
    try {
        keepRoomFor(batch.blockCount(), threads);
    } catch (const std::exception&) {
        // The most that any scan of so many blocks may need is soon told. What this one needs
        // is far less, and takes longer than the update.
        threads = 1;
        keepRoomFor(
            [&](const BlockVisitor& visit) { forEachWritten(batch, model, policy, visit); });
    }
    noteUpdate(model);
    return threads;
}

#define SUPERRAY_INSTANTIATE(Dim)                                                              \
    template void OccupancyMap<Dim>::forEachWritten(                                           \
        const UpdateBatch<Dim>&, const SensorModel&, UpdatePolicy, const BlockVisitor&) const; \
    template void OccupancyMap<Dim>::forEachWritten(                                           \
        const CellCountMap<Dim>&, const SensorModel&, UpdatePolicy, const BlockVisitor&)       \
        const;                                                                                 \
    template void OccupancyMap<Dim>::apply(const CellCountMap<Dim>&, const SensorModel&,       \
                                           UpdatePolicy);                                      \
    template void OccupancyMap<Dim>::setBlocks(const WrittenBlocks&);                          \
    template unsigned OccupancyMap<Dim>::beginUpdate(                                          \
        const UpdateBatch<Dim>&, const SensorModel&, UpdatePolicy, unsigned);
SUPERRAY_INSTANTIATE(2)
SUPERRAY_INSTANTIATE(3)
#undef SUPERRAY_INSTANTIATE

}  // namespace superray
