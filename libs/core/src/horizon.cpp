#include "horizon.h"

namespace superray {
namespace {

/// What a digital line may be off the straight one [cells], with room to spare:
/// it lags by less than (2^16 + 2) * 2^-31.
constexpr float kLag = 1.0f / (1 << 12);
/// What slopes of tiles and footprints may be off, with room to spare.
constexpr float kSlopeError = 1.0f / (1 << 18);

int bitLength(std::uint32_t x) {
    return x == 0 ? 0 : 32 - __builtin_clz(x);
}

}  // namespace

template <int Dim>
void Horizon<Dim>::reset(const DirectionTiles<Dim>& tiles, const Units<Dim>& origin) {
    tiles_ = tiles;
    perKind_ = tiles.perKind();
    used_ = 0;
    levelBegin_.clear();
    for (int l = 0; l <= tiles.levels; ++l) levelBegin_.push_back(tiles.levelBegin(l));
    reach_.resize(tiles.count());
    open_.resize(tiles.count());
    for (int a = 0; a < Dim; ++a) {
        sensor_[a] = RayLine<Dim>::cellOfUnits(origin[a]);
        within_[a] = static_cast<float>(origin[a] & (kUnitsPerCell - 1)) /
                     static_cast<float>(kUnitsPerCell);
    }
}

template <int Dim>
void Horizon<Dim>::use(std::uint32_t kind) {
    used_ |= 1u << kind;
    const auto first = static_cast<std::ptrdiff_t>(kind * perKind_);
    std::fill_n(reach_.begin() + first, perKind_, Extent{});
}

template <int Dim>
void Horizon<Dim>::completeReach() {
    for (std::uint32_t left = used_; left != 0; left &= left - 1) {
        Extent* const kind =
            reach_.data() + perKind_ * static_cast<unsigned>(__builtin_ctz(left));
        for (int level = 1; level <= tiles_.levels; ++level) {
            const Extent* fine = kind + levelBegin_[static_cast<std::size_t>(level - 1)];
            Extent* coarse = kind + levelBegin_[static_cast<std::size_t>(level)];
            const std::uint32_t edge = tiles_.edge(level);
            for (std::uint32_t y = 0; y < (Dim == 3 ? edge : 1); ++y) {
                for (std::uint32_t x = 0; x < edge; ++x) {
                    coarse[x] = largest(fine[2 * x], fine[2 * x + 1]);
                    if (Dim == 3)
                        coarse[x] = largest(coarse[x], largest(fine[2 * edge + 2 * x],
                                                               fine[2 * edge + 2 * x + 1]));
                }
                coarse += edge;
                fine += 4 * edge;
            }
        }
    }
}

template <int Dim>
void Horizon<Dim>::clear() {
    for (std::uint32_t left = used_; left != 0; left &= left - 1)
        std::fill_n(open_.begin() + static_cast<std::ptrdiff_t>(
                                        perKind_ * static_cast<unsigned>(__builtin_ctz(left))),
                    perKind_, kNever);
    open_[tiles_.lone()] = 0;
}

template <int Dim>
void Horizon<Dim>::openAll() {
    std::fill(open_.begin(), open_.end(), Slice{0});
}

template <int Dim>
void Horizon<Dim>::completeOpen() {
    for (std::uint32_t left = used_; left != 0; left &= left - 1) {
        Slice* const kind = open_.data() + perKind_ * static_cast<unsigned>(__builtin_ctz(left));
        for (int level = tiles_.levels; level > 0; --level) {
            Slice* fine = kind + levelBegin_[static_cast<std::size_t>(level - 1)];
            const Slice* coarse = kind + levelBegin_[static_cast<std::size_t>(level)];
            const std::uint32_t edge = tiles_.edge(level);
            for (std::uint32_t y = 0; y < (Dim == 3 ? 2 * edge : 1); ++y) {
                const Slice* const row = coarse + (Dim == 3 ? y / 2 * edge : 0);
                for (std::uint32_t x = 0; x < edge; ++x) {
                    fine[2 * x] = std::min(fine[2 * x], row[x]);
                    fine[2 * x + 1] = std::min(fine[2 * x + 1], row[x]);
                }
                fine += 2 * edge;
            }
        }
    }
}

/// A ray visits a cell in slice k only if, somewhere between entering and leaving
/// the slice, its minor coordinates are within those of the cell. So its slope is
/// between (nearest minor / farthest dominant) and (farthest / nearest).
template <int Dim>
template <typename Visit>
void Horizon<Dim>::forEachFootprint(const Cell<Dim>& lowest, const Cell<Dim>& highest,
                                    const Visit& visit) const {
    const auto tilesPerAxis = static_cast<float>(tiles_.edge(0));
    const float lastTile = tilesPerAxis - 1;
    std::uint32_t possible = 0;  // bit: sides of the axes on which the box lies
    for (std::uint32_t side = 0; side < 1u << Dim; ++side) {
        bool there = true;
        for (int a = 0; a < Dim; ++a)
            there &= side >> a & 1 ? lowest[a] <= sensor_[a] : highest[a] >= sensor_[a];
        possible |= there ? 1u << side : 0u;
    }
    for (; possible != 0; possible &= possible - 1) {
        const auto side = static_cast<std::uint32_t>(__builtin_ctz(possible));
        std::int32_t nearest[Dim];
        float near[Dim], far[Dim];  // of the box, as seen from the origin [cells]
        for (int a = 0; a < Dim; ++a) {
            const bool back = side >> a & 1;
            const std::int32_t low = back ? sensor_[a] - highest[a] : lowest[a] - sensor_[a];
            const std::int32_t high = back ? sensor_[a] - lowest[a] : highest[a] - sensor_[a];
            const float within = back ? 1 - within_[a] : within_[a];
            nearest[a] = std::max(low, 0);
            near[a] = static_cast<float>(nearest[a]) - within;
            far[a] = static_cast<float>(high + 1) - within;
        }
        Extent extent{};
        for (int a = 0; a < Dim; ++a) extent[a] = static_cast<std::uint16_t>(nearest[a]);
        for (int d = 0; d < Dim; ++d) {
            const std::uint32_t kind = static_cast<std::uint32_t>(d) | side << 2;
            if ((used_ >> kind & 1) == 0) continue;
            // Beyond 2^16 - 2 slices, rays begin there at the latest.
            Footprint f{kind,
                        static_cast<Slice>(std::min<std::int32_t>(nearest[d], kNever - 1)),
                        extent,
                        {0, 0},
                        {0, 0}};
            const float perFar = 1 / far[d];
            const float perNear = near[d] > 0 ? 1 / near[d] : std::numeric_limits<float>::max();
            bool seen = true;
            for (int a = 0, m = 0; a < Dim; ++a) {
                if (a == d) continue;
                const float low = (near[a] - kLag) * perFar - kSlopeError;
                const float high = (far[a] + kLag) * perNear + kSlopeError;
                seen &= low <= 1;
                f.low[m] = static_cast<std::uint32_t>(
                    std::clamp(low * tilesPerAxis, 0.0f, lastTile));
                f.high[m] = static_cast<std::uint32_t>(
                    std::clamp(high * tilesPerAxis, 0.0f, lastTile));
                ++m;
            }
            if (seen && !visit(f)) return;
        }
    }
}

/// Visits tiles of a level until visit(tile) returns true. \return whether it did
template <int Dim>
template <typename Visit>
bool Horizon<Dim>::anyTile(const Footprint& f, int level, const Visit& visit) const {
    const std::uint32_t begin = f.kind * perKind_ + levelBegin_[static_cast<std::size_t>(level)];
    const int bits = tiles_.levels - level;
    for (std::uint32_t y = f.low[1] >> level; y <= f.high[1] >> level; ++y)
        for (std::uint32_t x = f.low[0] >> level; x <= f.high[0] >> level; ++x)
            if (visit(begin + (y << bits) + x)) return true;
    return false;
}

template <int Dim>
bool Horizon<Dim>::reaches(const Cell<Dim>& lowest, const Cell<Dim>& highest) const {
    bool reached = false;
    forEachFootprint(lowest, highest, [&](const Footprint& f) {
        const std::uint32_t width = std::max(f.high[0] - f.low[0], f.high[1] - f.low[1]);
        // Two or three tiles per axis.
        const int level = std::min(tiles_.levels, std::max(0, bitLength(width) - 1));
        reached = anyTile(f, level, [&](std::uint32_t tile) { return within(f.extent, reach_[tile]); });
        return !reached;
    });
    return reached;
}

template <int Dim>
void Horizon<Dim>::open(const Cell<Dim>& cell) {
    forEachFootprint(cell, cell, [&](const Footprint& f) {
        const std::uint32_t width = std::max(f.high[0] - f.low[0], f.high[1] - f.low[1]);
        // Up to five tiles per axis, so that a coarse one adds little.
        const int level = std::min(tiles_.levels, std::max(0, bitLength(width) - 2));
        anyTile(f, level, [&](std::uint32_t tile) {
            if (within(f.extent, reach_[tile])) open_[tile] = std::min(open_[tile], f.slice);
            return false;
        });
        return true;
    });
}

template class Horizon<2>;
template class Horizon<3>;

}  // namespace superray
