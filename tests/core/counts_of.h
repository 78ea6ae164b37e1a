// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The counts of a batch, cell by cell.

#include <superray/core/cell_counts.h>
#include <superray/core/update_batch.h>

namespace superray::test {

/// Of the cells with a miss or a hit.
template <int Dim>
CellCountMap<Dim> countsOf(const UpdateBatch<Dim>& batch) {
    CellCountMap<Dim> counts;
    for (std::size_t b = 0; b < batch.blockCount(); ++b) {
        const BlockMask<Dim> touched = batch.touched(b);
        for (int i = 0; i < kBlockCells<Dim>; ++i) {
            if (!touched.test(i)) continue;
            const std::uint32_t hits = batch.hits(b) != nullptr ? batch.hits(b)[i] : 0;
            counts[cellInBlock<Dim>(batch.key(b), i)] = {batch.misses(b)[i], hits};
        }
    }
    return counts;
}

}  // namespace superray::test
