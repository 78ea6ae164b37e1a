#pragma once
// What noting open cells in a horizon needs to know of it.

#include <superray/core/block.h>

#include "directions/ray_directions.h"

#include <limits>

namespace superray {

/// What a digital line may be off the straight one [cells], with room to spare:
/// it lags by less than (2^16 + 2) * 2^-31.
inline constexpr float kLag = 1.0f / (1 << 12);
/// What slopes of tiles and footprints may be off, with room to spare.
inline constexpr float kSlopeError = 1.0f / (1 << 18);

inline int bitLength(std::uint32_t x) {
    return x == 0 ? 0 : 32 - __builtin_clz(x);
}

/// The inverse of the nearest dominant coordinate of what may surround the sensor.
inline float perNearOf(float near) {
    return near > 0 ? 1 / near : std::numeric_limits<float>::max();
}

/// A block as seen by the rays of a kind.
template <int Dim>
struct BlockSight {
    std::uint32_t kind;
    int dominant;
    bool back[Dim];                 ///< per axis: runs backwards
    std::int32_t nearest[Dim];      ///< cells from the sensor's cell, >= 0
    float near[Dim], far[Dim];      ///< from the origin [cells]
    std::uint32_t low[2], high[2];  ///< tiles that see it, per minor axis
};

template <int Dim>
struct HorizonView {
    /// Vector loads and stores may go so many elements beyond the tiles' arrays.
    static constexpr std::size_t kSlack = 8;

    Cell<Dim> sensor;
    float within[Dim];  ///< of the origin in its cell
    DirectionTiles<Dim> tiles;
    const std::uint32_t* levelBegin;  ///< per level, see DirectionTiles
    const Extent* reach;              ///< per tile
    Opening* open;                    ///< per tile
};

/// Notes open cells of a block in the tiles of rays of one kind that may visit them.
/// \return how many tiles it changed of which all spots are open
template <int Dim>
using NoteOpen = std::uint32_t (*)(const HorizonView<Dim>& horizon,
                                   const BlockSight<Dim>& sight, const BlockKey<Dim>& block,
                                   const BlockMask<Dim>& cells);

}  // namespace superray
