// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What noting boundary cells in a ranges needs to know of it.

#include <superray/core/block.h>

#include "directions/classified_batch.h"

#include <limits>

namespace superray {

/// What a digital line may be off the straight one [cells], with room to spare:
/// it lags by less than (2^16 + 2) * 2^-31.
inline constexpr float kLag = 1.0f / (1 << 12);
/// What slopes of bins and footprints may be off, with room to spare.
inline constexpr float kSlopeError = 1.0f / (1 << 18);

inline int bitLength(std::uint32_t x) {
    return x == 0 ? 0 : 32 - __builtin_clz(x);
}

/// The inverse of the nearest major coordinate of what may surround the sensor.
inline float perNearOf(float near) {
    return near > 0 ? 1 / near : std::numeric_limits<float>::max();
}

/// A block as seen by the rays of a sector.
template <int Dim>
struct BlockInSector {
    std::uint32_t sector;
    int major;
    bool back[Dim];                 ///< per axis: runs backwards
    std::int32_t nearest[Dim];      ///< cells from the sensor's cell, >= 0
    float near[Dim], far[Dim];      ///< from the origin [cells]
    std::uint32_t low[2], high[2];  ///< bins that see it, per minor axis
};

template <int Dim>
struct RangesView {
    /// Vector loads and stores may go so many elements beyond the bins' arrays.
    static constexpr std::size_t kSlack = 8;

    Cell<Dim> sensor;
    float within[Dim];  ///< of the origin in its cell
    DirectionBins<Dim> bins;
    const std::uint32_t* levelBegin;  ///< per level, see DirectionBins
    const CellOffset* farthest;       ///< per bin
    FirstUnsettled* unsettled;        ///< per bin
};

/// Notes boundary cells of a block in the bins of rays of one sector that may visit them.
/// \return how many bins it changed of which all sub-bins are open
template <int Dim>
using MarkBoundary = std::uint32_t (*)(const RangesView<Dim>& ranges,
                                       const BlockInSector<Dim>& sight,
                                       const BlockKey<Dim>& block, const BlockMask<Dim>& cells);

}  // namespace superray
