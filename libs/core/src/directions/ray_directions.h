#pragma once
// Roughly where each ray of a scan goes: in which tile of the horizon, and how far.

#include <superray/core/ray_bundle.h>

#include "counting/block_directory.h"
#include "skipping/opening.h"
#include "directions/packed_triple.h"

#include <array>

namespace superray {

/// How many cells from the sensor's cell, per axis; without a sign, for that is
/// the kind's.
using Extent = PackedTriple;

/// Directions as seen from the common origin of a scan. The kind of a ray is its
/// dominant axis, + 4 * (bit a: axis a runs backwards). Of each kind, a square of
/// (in 2D, a row of) tiles covers the slopes minor / dominant, 0 .. 1 per minor
/// axis. Tiles are followed by those of coarser levels, down to one tile. A tile has
/// 4 * 4 spots (in 2D, 4 by 4 that are alike): a spot's number is 16 * tile + spot in it.
template <int Dim>
struct DirectionTiles {
    static constexpr std::uint32_t kKinds = 1u << (2 + Dim);
    static constexpr int kMostLevels = Dim == 2 ? 12 : 6;

    static constexpr int kSpotBits = 4;
    static_assert(1 << kSpotBits == Opening::kSpots);
    static constexpr int kAxisSpotBits = 2;
    static constexpr int kAxisSpots = 1 << kAxisSpotBits;  ///< of a tile, per minor axis

    int levels = 0;  ///< 2^levels tiles per minor axis

    static constexpr std::uint32_t tileOf(std::uint32_t spot) { return spot >> kSpotBits; }
    static constexpr std::uint32_t firstSpot(std::uint32_t tile) { return tile << kSpotBits; }

    std::uint32_t edge(int level) const { return 1u << (levels - level); }
    /// Index of a level's first tile, from the kind's first.
    std::uint32_t levelBegin(int level) const {
        std::uint32_t begin = 0;
        for (int l = 0; l < level; ++l) begin += 1u << ((Dim - 1) * (levels - l));
        return begin;
    }
    /// Tiles from one kind to the next: a power of two, to find the kind of a spot
    /// by a shift.
    int perKindBits() const { return (Dim - 1) * levels + 1; }
    std::uint32_t perKind() const { return 1u << perKindBits(); }
    std::uint32_t kindOf(std::uint32_t spot) const {
        return spot >> (perKindBits() + kSpotBits);
    }
    /// A tile of its own for rays of which single precision cannot tell a kind.
    std::uint32_t lone() const { return kKinds * perKind(); }
    /// One for rays that have nothing more to tell.
    std::uint32_t spent() const { return lone() + 1; }
    std::uint32_t count() const { return spent() + 1; }
};

/// Where some rays in a row go and end.
template <int Dim>
struct RayDirections {
    static constexpr std::size_t kMost = 1024;  ///< rays: as many as the L1 cache holds
    static constexpr std::size_t kSlack = 16;   ///< what vector loads may read beyond

    static constexpr float kLeastLength = 1.0f / 64;  ///< [cells]
    /// Slices of longer rays might not fit the horizon's 16 bits [cells].
    static constexpr float kGreatestLength = 65000;
    static constexpr float kLeastExtent = 1.0f / (1 << 24);
    static constexpr float kCertain = 1 - 1.0f / (1 << 19);  ///< slopes below are minor
    /// Spots are those of slopes in single precision, off the exact ones by less.
    static constexpr double kSlopeMargin = 1.0 / (1 << 20);

    const std::uint32_t* spot;                  ///< per ray; of lone rays: the first one
    std::array<Extent, kMost + kSlack> extent;  ///< of the end cell
    std::array<std::uint32_t, kMost> block;     ///< BlockDirectory::indexOf(), if it is dense
    std::array<std::uint16_t, kMost> local;     ///< index of the end cell in its block
    std::uint32_t kinds;                        ///< bit k: there are rays of kind k
    std::uint32_t lone;                         ///< DirectionTiles::lone()
};

/// Of `count` rays from `first` on.
/// \param directory covers the scan
/// \param spot of each ray, with kSlack more
/// \param lastSlice of each ray: in which it ends (of lone rays, any)
/// \pre count <= RayDirections::kMost
template <int Dim>
using FindDirections = void (*)(const RayBundle<Dim>& rays, std::size_t first,
                                std::size_t count, const BlockDirectory<Dim>& directory,
                                const DirectionTiles<Dim>& tiles, std::uint32_t* spot,
                                std::uint16_t* lastSlice, RayDirections<Dim>& out);

/// Finds runs of rays that go and end alike among the first `count` rays: where they
/// begin. Lone rays are runs of their own, for they may go opposite ways.
/// \param starts has room for kSlack more than there are rays
/// \return number of runs
template <int Dim>
using FindRuns = std::size_t (*)(const RayDirections<Dim>& directions, const RayEnd* ends,
                                 std::size_t count, std::uint32_t* starts);

/// Chooses among `count` rays those of open spots whose last slice is not before the
/// first open one of their tile, in order.
/// \param lastSlice of each ray, with kSlack more
/// \param openings of each tile
/// \param chosen has room for kSlack more than there are rays
/// \return number of rays chosen
using ChooseRays = std::size_t (*)(const std::uint32_t* spot, const std::uint16_t* lastSlice,
                                   std::size_t count, const Opening* openings,
                                   std::uint32_t* chosen);

}  // namespace superray
