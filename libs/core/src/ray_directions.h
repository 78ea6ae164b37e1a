#pragma once
// Roughly where each ray of a scan goes: in which tile of the horizon, and how far.

#include <superray/core/ray_bundle.h>

#include <vector>

namespace superray {

/// How many cells from the sensor's cell, per axis; without a sign, for that is
/// the kind's. Three numbers in one word, each with a bit above it to compare all
/// of them at once.
class Extent {
 public:
    static constexpr int kBits = 21;

    Extent() = default;
    explicit Extent(std::uint64_t packed) : packed_(packed) {}
    /// \param cells 0 <= cells < 2^20
    void set(int axis, std::int32_t cells) {
        packed_ |= std::uint64_t{static_cast<std::uint32_t>(cells)} << (kBits * axis);
    }
    std::int32_t operator[](std::uint32_t axis) const {
        return static_cast<std::int32_t>(packed_ >> (kBits * axis) & (kAbove - 1));
    }
    bool operator==(Extent o) const { return packed_ == o.packed_; }
    /// On every axis not farther than the other.
    bool within(Extent o) const { return (((o.packed_ | kAll) - packed_) & kAll) == kAll; }
    /// The farther one on each axis.
    Extent joined(Extent o) const {
        const std::uint64_t others = ((o.packed_ | kAll) - packed_) & kAll;
        const std::uint64_t mask = others - (others >> (kBits - 1));  // whole fields
        return Extent((o.packed_ & mask) | (packed_ & ~mask));
    }

 private:
    static constexpr std::uint64_t kAbove = std::uint64_t{1} << (kBits - 1);
    static constexpr std::uint64_t kAll = kAbove | kAbove << kBits | kAbove << (2 * kBits);
    std::uint64_t packed_ = 0;
};

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
    std::vector<Extent> extent;  ///< of the end cell

    static constexpr float kLeastLength = 1.0f / 64;  ///< [cells]
    /// Slices of longer rays might not fit the horizon's 16 bits [cells].
    static constexpr float kGreatestLength = 65000;
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
