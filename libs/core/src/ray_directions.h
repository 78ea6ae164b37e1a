#pragma once
// Roughly where each ray of a scan goes: in which tile of the horizon, and how far.

#include <superray/core/ray_bundle.h>

#include "block_directory.h"
#include "packed_triple.h"

#include <algorithm>
#include <array>
#include <vector>

namespace superray {

/// How many cells from the sensor's cell, per axis; without a sign, for that is
/// the kind's.
using Extent = PackedTriple;

/// What a ray is compared with open cells by: the slopes of its minor axes in
/// steps of 2^-kAimBits (in 2D, the second is 0), and the slice in which it ends.
using Aim = PackedTriple;
inline constexpr int kAimBits = 16;

/// Directions as seen from the common origin of a scan. The kind of a ray is its
/// dominant axis, + 4 * (bit a: axis a runs backwards). Of each kind, a square of
/// (in 2D, a row of) tiles covers the slopes minor / dominant, 0 .. 1 per minor
/// axis. Tiles are followed by those of coarser levels, down to one tile.
template <int Dim>
struct DirectionTiles {
    static constexpr std::uint32_t kKinds = 1u << (2 + Dim);
    static constexpr int kMostLevels = Dim == 2 ? 12 : 7;

    int levels = 0;  ///< 2^levels tiles per minor axis

    std::uint32_t edge(int level) const { return 1u << (levels - level); }
    /// Index of a level's first tile, from the kind's first.
    std::uint32_t levelBegin(int level) const {
        std::uint32_t begin = 0;
        for (int l = 0; l < level; ++l) begin += 1u << ((Dim - 1) * (levels - l));
        return begin;
    }
    /// Tiles from one kind to the next: a power of two, to find the kind of a tile
    /// by a shift.
    int perKindBits() const { return (Dim - 1) * levels + 1; }
    std::uint32_t perKind() const { return 1u << perKindBits(); }
    std::uint32_t kindOf(std::uint32_t tile) const { return tile >> perKindBits(); }
    /// A tile of its own for rays of which single precision cannot tell a kind.
    std::uint32_t lone() const { return kKinds * perKind(); }
    std::uint32_t count() const { return lone() + 1; }
};

/// Per ray.
template <int Dim>
struct RayDirections {
    DirectionTiles<Dim> tiles;
    std::vector<std::uint32_t> tile;
    std::vector<Aim> aim;

    static constexpr float kLeastLength = 1.0f / 64;  ///< [cells]
    /// Slices of longer rays might not fit the horizon's 16 bits [cells].
    static constexpr float kGreatestLength = 65000;
    static constexpr float kLeastExtent = 1.0f / (1 << 24);
    static constexpr float kCertain = 1 - 1.0f / (1 << 19);  ///< slopes below are minor
    /// Tiles are those of slopes in single precision, off the exact ones by less.
    static constexpr double kSlopeMargin = 1.0 / (1 << 20);

    void resize(std::size_t n) {
        tile.resize(n);
        aim.resize(n);
    }
};

/// Where some rays in a row end.
struct RayEnds {
    static constexpr std::size_t kMost = 1024;  ///< rays: as many as the L1 cache holds

    std::array<Extent, kMost> extent;
    std::array<std::uint32_t, kMost> block;  ///< BlockDirectory::indexOf(), if it is dense
    std::array<std::uint16_t, kMost> local;  ///< index of the cell in its block
    std::uint32_t kinds;                     ///< bit k: there are rays of kind k
};

/// Of `count` rays from `first` on, to out from `at` on.
/// \param directory covers the scan
/// \pre count <= RayEnds::kMost; out.resize() was called, out.tiles is set
template <int Dim>
using FindDirections = void (*)(const RayBundle<Dim>& rays, std::size_t first,
                                std::size_t count, const BlockDirectory<Dim>& directory,
                                RayDirections<Dim>& out, std::size_t at, RayEnds& ends);

}  // namespace superray
