// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file cell_counts.h
/// Exact numbers of misses and hits per cell, for scans and models that the 8-bit counts of
/// an UpdateBatch do not serve.

#include <superray/core/block.h>

#include <cstdint>
#include <unordered_map>

namespace superray {

/// Counts of one cell in one scan; they do not saturate.
struct CellCounts {
    std::uint32_t misses = 0;  ///< rays that pass through the cell
    std::uint32_t hits = 0;    ///< returns that end in it
};

/// Counts of all cells that a scan touches, in no particular order.
template <int Dim>
using CellCountMap = std::unordered_map<Cell<Dim>, CellCounts, IndexHash>;

}  // namespace superray
