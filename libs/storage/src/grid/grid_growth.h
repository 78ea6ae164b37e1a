// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What writing to a block grid may take, found without writing; and memory for it.

#include "grid/grid_blocks.h"

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

}  // namespace superray::grid
