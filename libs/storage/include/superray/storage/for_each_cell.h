// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file for_each_cell.h

#include <superray/storage/occupancy_map.h>

namespace superray {

/// Calls visit(cell, log-odds) for every known cell, block by block.
template <int Dim, class Visit>
void forEachCell(const OccupancyMap<Dim>& map, const Visit& visit) {
    map.forEachBlock([&](const BlockView<Dim>& block) {
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (block.known.test(i)) visit(cellInBlock<Dim>(block.key, i), block.values[i]);
    });
}

}  // namespace superray
