#include "skipping/horizon.h"

#include "threads/in_turns.h"
#include "kernels/walk_kernel.h"

namespace superray {
namespace {

/// A tile's spots as those of the tile below that covers its (x, y)th quarter.
std::uint32_t spotsBelow(std::uint32_t spots, std::uint32_t x, std::uint32_t y) {
    const std::uint32_t s = spots >> (2 * x + 8 * y);
    const std::uint32_t rows = 3 * (s & 0x11) | 6 * (s & 0x22);  // columns twice
    return 0x11 * (rows & 0x0F) | 0x110 * (rows & 0xF0);
}

}  // namespace

template <int Dim>
void Horizon<Dim>::reset(const DirectionTiles<Dim>& tiles, const Units<Dim>& origin) {
    tiles_ = tiles;
    perKind_ = tiles.perKind();
    used_ = 0;
    tilesWithRays_ = 0;
    levelBegin_.clear();
    for (int l = 0; l <= tiles.levels; ++l) levelBegin_.push_back(tiles.levelBegin(l));
    reach_.reserve(tiles.count() + HorizonView<Dim>::kSlack);
    open_.reserve(tiles.count() + HorizonView<Dim>::kSlack);
    limit_.reserve(tiles.count());
    reach_[tiles.lone()] = Extent{};
    for (int a = 0; a < Dim; ++a) {
        sensor_[a] = RayLine<Dim>::cellOfUnits(origin[a]);
        within_[a] = static_cast<float>(origin[a] & (kUnitsPerCell - 1)) /
                     static_cast<float>(kUnitsPerCell);
    }
}

template <int Dim>
void Horizon<Dim>::use(std::uint32_t kinds) {
    for (std::uint32_t left = kinds & ~used_; left != 0; left &= left - 1)
        std::fill_n(
            reach_.data() + std::size_t{perKind_} * static_cast<unsigned>(__builtin_ctz(left)),
            perKind_, Extent{});
    used_ |= kinds;
}

template <int Dim>
void Horizon<Dim>::addRays(const RayDirections<Dim>& directions, const std::uint32_t* rays,
                           std::size_t count) {
    use(directions.kinds);
    reachGrows_.learn(reachGrows_.unpredictable()
                          ? addInTurns<Branches::none>(directions, rays, count)
                          : addInTurns<Branches::predicted>(directions, rays, count),
                      count);
}

/// Neighbours often go the same way.
/// \return number of rays that changed something
template <int Dim>
template <Branches branches>
std::size_t Horizon<Dim>::addInTurns(const RayDirections<Dim>& directions,
                                     const std::uint32_t* rays, std::size_t count) {
    std::size_t changes = 0;
    inTurns(count, [&](std::size_t, std::size_t i) {
        const Extent extent = directions.extent[rays[i]];
        // That of the lone tile is not used.
        Extent& reach = reach_[DirectionTiles<Dim>::tileOf(directions.spot[rays[i]])];
        const bool change = !extent.within(reach);
        changes += change;
        if (branches == Branches::none || change) reach = reach.joined(extent);
    });
    return changes;
}

template <int Dim>
void Horizon<Dim>::completeReach() {
    for (std::uint32_t left = used_; left != 0; left &= left - 1) {
        Extent* const kind =
            reach_.data() + perKind_ * static_cast<unsigned>(__builtin_ctz(left));
        for (std::uint32_t t = 0; t < levelBegin_.data()[1]; ++t)
            tilesWithRays_ += kind[t] != Extent();
        raise(kind, [](Extent x, Extent y) { return x.joined(y); });
    }
}

/// Fills in the coarser levels of a kind: what is joined of the tiles below.
template <int Dim>
template <typename Value, typename Join>
void Horizon<Dim>::raise(Value* kind, const Join& join) const {
    for (int level = 1; level <= tiles_.levels; ++level) {
        const Value* fine = kind + levelBegin_[static_cast<std::size_t>(level - 1)];
        Value* coarse = kind + levelBegin_[static_cast<std::size_t>(level)];
        const std::uint32_t edge = tiles_.edge(level);
        for (std::uint32_t y = 0; y < (Dim == 3 ? edge : 1); ++y) {
            for (std::uint32_t x = 0; x < edge; ++x) {
                coarse[x] = join(fine[2 * x], fine[2 * x + 1]);
                if (Dim == 3)
                    coarse[x] = join(coarse[x],
                                     join(fine[2 * edge + 2 * x], fine[2 * edge + 2 * x + 1]));
            }
            coarse += edge;
            fine += 4 * edge;
        }
    }
}

template <int Dim>
void Horizon<Dim>::clear() {
    fillOpenings(Opening::never());
    completeLimits();
}

template <int Dim>
void Horizon<Dim>::openAll() {
    fillOpenings(Opening::all(0));
}

/// All tiles, but that of the lone rays, which are walked from the beginning.
template <int Dim>
void Horizon<Dim>::fillOpenings(Opening opening) {
    for (std::uint32_t left = used_; left != 0; left &= left - 1)
        std::fill_n(
            open_.data() + std::size_t{perKind_} * static_cast<unsigned>(__builtin_ctz(left)),
            perKind_, opening);
    open_[tiles_.lone()] = Opening::all(0);
    open_[tiles_.spent()] = Opening::never();
}

template <int Dim>
void Horizon<Dim>::completeOpen() {
    for (std::uint32_t left = used_; left != 0; left &= left - 1) {
        Opening* const kind =
            open_.data() + perKind_ * static_cast<unsigned>(__builtin_ctz(left));
        for (int level = tiles_.levels; level > 0; --level) {
            Opening* const fine = kind + levelBegin_[static_cast<std::size_t>(level - 1)];
            const Opening* const coarse = kind + levelBegin_[static_cast<std::size_t>(level)];
            const std::uint32_t edge = tiles_.edge(level);
            const std::uint32_t count = Dim == 3 ? edge * edge : edge;
            for (std::uint32_t t = 0; t < count; ++t) {
                const Opening above = coarse[t];
                if (above.spots() == 0) continue;
                Opening* const below = fine + 4 * (t & ~(edge - 1)) + 2 * (t & (edge - 1));
                for (std::uint32_t y = 0; y < (Dim == 3 ? 2 : 1); ++y)
                    for (std::uint32_t x = 0; x < 2; ++x) {
                        const std::uint32_t spots = spotsBelow(above.spots(), x, y);
                        Opening& to = below[2 * edge * y + x];
                        if (spots != 0) to = to.joined(Opening::of(above.slice(), spots));
                    }
            }
        }
    }
}

/// How far there is something to see: as far as rays reach, but not where all of them
/// are walked anyway.
template <int Dim>
void Horizon<Dim>::completeLimits() {
    opened_ = 0;
    for (std::uint32_t left = used_; left != 0; left &= left - 1) {
        const auto number = static_cast<unsigned>(__builtin_ctz(left));
        const unsigned d = number & 3;
        Slice* const kind = limit_.data() + perKind_ * number;
        const Extent* const reach = reach_.data() + perKind_ * number;
        const Opening* const open = open_.data() + perKind_ * number;
        for (std::uint32_t t = 0; t < levelBegin_.data()[1]; ++t) {
            const auto end = static_cast<Slice>(reach[t][d] + 1);
            const bool all = open[t].spots() == Opening::kAllSpots;
            kind[t] = std::min(end, all ? open[t].slice() : kNever);
        }
        raise(kind, [](Slice x, Slice y) { return std::max(x, y); });
    }
}

/// A ray visits a cell in slice k only if, somewhere between entering and leaving
/// the slice, its minor coordinates are within those of the cell. So its slope is
/// between (nearest minor / farthest dominant) and (farthest / nearest).
template <int Dim>
template <typename Visit>
void Horizon<Dim>::forEachSight(const BlockKey<Dim>& block, const Visit& visit) const {
    const auto tilesPerAxis = static_cast<float>(tiles_.edge(0));
    const float lastTile = tilesPerAxis - 1;
    const Cell<Dim> lowest = cellInBlock<Dim>(block, 0);
    for (std::uint32_t side = 0; side < 1u << Dim; ++side) {
        BlockSight<Dim> s;
        bool there = true;
        for (int a = 0; a < Dim; ++a) {
            const bool back = s.back[a] = side >> a & 1;
            const std::int32_t highest = lowest[a] + kBlockEdge - 1;
            there &= back ? lowest[a] <= sensor_[a] : highest >= sensor_[a];
            const std::int32_t low = back ? sensor_[a] - highest : lowest[a] - sensor_[a];
            const float within = back ? 1 - within_[a] : within_[a];
            s.nearest[a] = std::max(low, 0);
            s.near[a] = static_cast<float>(s.nearest[a]) - within;
            s.far[a] = static_cast<float>(low + kBlockEdge) - within;
        }
        if (!there) continue;
        for (int d = 0; d < Dim; ++d) {
            s.kind = static_cast<std::uint32_t>(d) | side << 2;
            if ((used_ >> s.kind & 1) == 0) continue;
            s.dominant = d;
            const float perFar = 1 / s.far[d];
            const float perNear = perNearOf(s.near[d]);
            bool seen = true;
            s.low[1] = s.high[1] = 0;
            for (int a = 0, m = 0; a < Dim; ++a) {
                if (a == d) continue;
                const float low = (s.near[a] - kLag) * perFar - kSlopeError;
                const float high = (s.far[a] + kLag) * perNear + kSlopeError;
                seen &= low <= 1;
                s.low[m] =
                    static_cast<std::uint32_t>(std::clamp(low * tilesPerAxis, 0.0f, lastTile));
                s.high[m] =
                    static_cast<std::uint32_t>(std::clamp(high * tilesPerAxis, 0.0f, lastTile));
                ++m;
            }
            if (seen && !visit(s)) return;
        }
    }
}

template <int Dim>
bool Horizon<Dim>::reaches(const BlockKey<Dim>& block) const {
    bool reached = false;
    forEachSight(block, [&](const BlockSight<Dim>& s) {
        Extent extent{};
        for (int a = 0; a < Dim; ++a) extent.set(a, s.nearest[a]);
        const std::uint32_t width = std::max(s.high[0] - s.low[0], s.high[1] - s.low[1]);
        // Two or three tiles per axis.
        const int level = std::min(tiles_.levels, std::max(0, bitLength(width) - 1));
        const std::uint32_t begin =
            s.kind * perKind_ + levelBegin_[static_cast<std::size_t>(level)];
        for (std::uint32_t y = s.low[1] >> level; y <= s.high[1] >> level; ++y)
            for (std::uint32_t x = s.low[0] >> level; x <= s.high[0] >> level; ++x) {
                const std::uint32_t tile = begin + (y << (tiles_.levels - level)) + x;
                reached |= extent.within(reach_[tile]) &&
                           limit_[tile] > extent[static_cast<unsigned>(s.dominant)];
            }
        return !reached;
    });
    return reached;
}

template <int Dim>
void Horizon<Dim>::open(const BlockKey<Dim>& block, const BlockMask<Dim>& cells) {
    static const NoteOpen<Dim> noteOpen = bestKernels<Dim>().noteOpen;
    HorizonView<Dim> view;
    view.sensor = sensor_;
    std::copy_n(within_, Dim, view.within);
    view.tiles = tiles_;
    view.levelBegin = levelBegin_.data();
    view.reach = reach_.data();
    view.open = open_.data();
    forEachSight(block, [&](const BlockSight<Dim>& s) {
        opened_ += noteOpen(view, s, block, cells);
        return true;
    });
    constexpr std::uint32_t kMany = 4096;
    if (opened_ >= kMany) completeLimits();
}

template class Horizon<2>;
template class Horizon<3>;

}  // namespace superray
