#pragma once
// Roughly where each ray of a scan goes: in which tile of the horizon, and how far.

#include <superray/core/ray_bundle.h>

#include <vector>

namespace superray {

/// How many cells from the sensor's cell, per axis; without a sign, for that is
/// the kind's. The rest is 0.
using Extent = std::uint16_t __attribute__((vector_size(8)));

/// Directions as seen from the common origin of a scan. The kind of a ray is its
/// dominant axis, + 4 * (bit a: axis a runs backwards). Of each kind, a square of
/// (in 2D, a row of) tiles covers the slopes minor / dominant, 0 .. 1 per minor
/// axis. Tiles are followed by those of coarser levels, down to one tile.
template <int Dim>
struct DirectionTiles {
    static constexpr std::uint32_t kKinds = 1u << (2 + Dim);
    static constexpr int kMostLevels = Dim == 2 ? 12 : 9;

    int levels = 0;  ///< 2^levels tiles per minor axis

    std::uint32_t edge(int level) const { return 1u << (levels - level); }
    /// Index of a level's first tile, from the kind's first.
    std::uint32_t levelBegin(int level) const {
        std::uint32_t begin = 0;
        for (int l = 0; l < level; ++l) begin += 1u << ((Dim - 1) * (levels - l));
        return begin;
    }
    std::uint32_t perKind() const { return levelBegin(levels + 1); }
    /// A tile of its own for rays of which single precision cannot tell a kind.
    std::uint32_t lone() const { return kKinds * perKind(); }
    std::uint32_t count() const { return lone() + 1; }
};

/// Per ray.
template <int Dim>
struct RayDirections {
    DirectionTiles<Dim> tiles;
    std::vector<std::uint32_t> tile;
    std::vector<Extent> extent;  ///< of the end cell

    static constexpr float kLeastLength = 1.0f / 64;  ///< [cells]
    static constexpr float kLeastExtent = 1.0f / (1 << 24);
    static constexpr float kCertain = 1 - 1.0f / (1 << 19);  ///< slopes below are minor
    /// Tiles are those of slopes in single precision, off the exact ones by less.
    static constexpr double kSlopeMargin = 1.0 / (1 << 20);

    void resize(std::size_t n) {
        tile.resize(n);
        extent.resize(n);
    }
};

/// Of the rays [begin, end), to out from 0 on.
/// \pre out.resize(end - begin) was called, out.tiles is set
template <int Dim>
using FindDirections = void (*)(const RayBundle<Dim>& rays, std::size_t begin, std::size_t end,
                                RayDirections<Dim>& out);

}  // namespace superray
