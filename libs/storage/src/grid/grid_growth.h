// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What writing to a block grid may take, found without writing; and memory for it.

#include "grid/grid_blocks.h"

#include <array>
#include <cstdint>
#include <unordered_set>

namespace superray::grid {

/// What blocks to come may take.
struct Growth {
    std::size_t pages = 0, payloads = 0, layers = 0;
};

/// The most that writing to so many blocks can make.
template <int Dim>
Growth growthAtMost(std::size_t blocks) {
    return {blocks, blocks, blocks * Payload<Dim>::kLayers};
}

template <int Dim>
Growth growthBy(const Blocks<Dim>& grid,
                const typename OccupancyMap<Dim>::WrittenBlocks& written) {
    using Table = typename Blocks<Dim>::Table;
    Growth growth;
    std::unordered_set<BlockKey<Dim>, IndexHash> pages;
    written([&](const BlockView<Dim>& view) {
        const auto place = grid.table.find(view.key);
        if (place == Table::kNowhere && pages.insert(Table::pageKey(view.key)).second)
            ++growth.pages;
        const Block* const block = grid.at(place);
        const bool hasPayload = block != nullptr && block->payload != kUniform;
        const bool isUniform = block != nullptr && !hasPayload;  // gets all layers
        if (!hasPayload) ++growth.payloads;
        for (std::size_t z = 0; z < Payload<Dim>::kLayers; ++z) {
            const bool hasLayer =
                hasPayload && grid.payloads[block->payload].layers[z] != kNoLayer;
            if (!hasLayer && (isUniform || view.known.words[z] != 0)) ++growth.layers;
        }
    });
    return growth;
}

/// Memory of the blocks, at most, after a growth.
template <int Dim>
std::size_t memoryBytesAtMost(const Blocks<Dim>& grid, const Growth& g) {
    return grid.table.memoryBytesAtMost(g.pages) + grid.payloads.memoryBytesAtMost(g.payloads) +
           grid.layers.memoryBytesAtMost(g.layers);
}

/// Makes sure that making these payloads and layers cannot fail.
/// \throws std::bad_alloc, std::length_error
template <int Dim>
void keepRoom(Blocks<Dim>& grid, const Growth& g) {
    grid.layers.keepRoom(g.layers);  // nearly all of it
    grid.payloads.keepRoom(g.payloads);
}

/// Makes the pages of a batch's blocks that will be written to. \throws std::bad_alloc
template <int Dim>
void makePages(Blocks<Dim>& grid, const UpdateBatch<Dim>& batch) {
    using Table = typename Blocks<Dim>::Table;
    // Most blocks are in a page of one before: these are not looked up again.
    std::array<std::uint64_t, 256> there;
    there.fill(Table::kNoPage);
    for (std::size_t b = 0; b < batch.blockCount(); ++b) {
        const std::uint64_t page = Table::pageOf(batch.key(b));
        std::uint64_t& last = there[(page * 0x9E3779B97F4A7C15ull) >> 56];
        if (last == page) continue;
        if (grid.table.find(batch.key(b)) == Table::kNowhere) {
            if (!batch.touched(b).any()) continue;
            grid.table.findOrMake(batch.key(b));
        }
        last = page;
    }
}

}  // namespace superray::grid
