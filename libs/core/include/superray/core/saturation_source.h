// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file saturation_source.h
/// What the engine asks of a map: in which cells would another miss change nothing?

#include <superray/core/block.h>

#include <algorithm>

namespace superray {

/// Saturation of the cells of one block, as the map has them before a scan.
template <int Dim>
struct BlockSaturation {
    /// Cells whose log-odds are at the lower clamp, exactly: misses leave them as they are.
    BlockMask<Dim> saturatedFree;
    /// False only if no cell has log-odds above 0. Then the number of misses that takes an
    /// unknown cell to the lower clamp takes every cell of the block there.
    bool mayExceedUnknown = false;
};

/// Bounds of the log-odds in a map; they may be wider than need be. Unknown cells count as 0.
struct LogOddsRange {
    float lowest = 0, highest = 0;

    void include(const LogOddsRange& other) {
        lowest = std::min(lowest, other.lowest);
        highest = std::max(highest, other.highest);
    }
};

/// A map that answers for one block at a time. Storages implement it; the engine calls it
/// from several threads at once, and never while the map changes.
template <int Dim>
class SaturationSource {
 public:
    virtual ~SaturationSource() = default;
    /// Saturation of a block; that of an unknown block is all false.
    /// \param key index of the block
    /// \param lowerClamp log-odds of the sensor model's lower clamp
    virtual BlockSaturation<Dim> saturation(const BlockKey<Dim>& key,
                                            float lowerClamp) const = 0;
    /// Bounds of all values. They may lie outside the clamps of the sensor model: those of a
    /// map that was loaded, or of options that have changed since.
    virtual LogOddsRange valueRange() const = 0;
};

}  // namespace superray
