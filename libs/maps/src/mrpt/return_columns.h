// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file return_columns.h
/// What a scan of a 3D sensor tells a 2D map.
///
/// A cell of a 2D map stands for the column of space above it. A ray crosses the column at
/// one height and tells nothing of what lies below or above: the rays that pass over a low
/// box must not clear it. So in the scan of a 3D sensor a cell in which a return lies is not
/// missed.

#include <superray/core/cell_counts.h>
#include <superray/core/update_batch.h>

namespace superray {

/// The counts without the misses of the cells that have hits.
template <int Dim>
UpdateBatch<Dim> withoutMissesOfHitCells(const UpdateBatch<Dim>& batch) {
    UpdateBatch<Dim> result;
    for (std::size_t b = 0; b < batch.blockCount(); ++b) {
        const auto block = result.addBlock(batch.key(b));
        const std::uint8_t* misses = batch.misses(b);
        const std::uint8_t* hits = batch.hits(b);
        std::uint8_t* const newHits = hits != nullptr ? result.hitsOf(block) : nullptr;
        std::uint8_t* const newMisses = result.missesOf(block);
        for (int i = 0; i < UpdateBatch<Dim>::kCells; ++i) {
            const bool isHit = hits != nullptr && hits[i] != 0;
            newMisses[i] = isHit ? std::uint8_t{0} : misses[i];
            if (isHit) newHits[i] = hits[i];
        }
    }
    return result;
}

template <int Dim>
CellCountMap<Dim> withoutMissesOfHitCells(CellCountMap<Dim> counts) {
    for (auto& entry : counts)
        if (entry.second.hits > 0) entry.second.misses = 0;
    return counts;
}

}  // namespace superray
