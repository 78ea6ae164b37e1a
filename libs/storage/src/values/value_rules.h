// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file value_rules.h
/// What every storage demands of cells and values written to it.

#include <superray/core/block.h>
#include <superray/core/update_batch.h>

namespace superray {

inline constexpr std::int32_t kBlockLimit = kCellLimit / kBlockEdge;

template <std::size_t N>
bool isAddressable(const std::array<std::int32_t, N>& index, std::int32_t limit) {
    for (const auto v : index)
        if (v < -limit || v >= limit) return false;
    return true;
}

template <int Dim>
BlockMask<Dim> fullMask() {
    BlockMask<Dim> m;
    m.words.fill(~std::uint64_t{0});
    return m;
}

/// \throws std::out_of_range naming the cell and the range
template <int Dim>
void requireAddressableCell(const Cell<Dim>& cell);
/// \throws std::out_of_range naming the block and the range
template <int Dim>
void requireAddressableBlock(const BlockKey<Dim>& key);
/// The same for all blocks of a batch.
template <int Dim>
void requireAddressableBlocks(const UpdateBatch<Dim>& batch);

/// The value as it is stored: -0 becomes +0, so that equal values have equal
/// bits (trees merge children that compare equal).
/// \throws std::invalid_argument if it is NaN or infinite
float storedValue(float value);

}  // namespace superray
