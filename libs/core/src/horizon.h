#pragma once
// The horizon of a scan: for each tile of directions, how far rays get there, and
// from where on they have something to tell.

#include <superray/core/ray_line.h>

#include "ray_directions.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace superray {

/// The farthest cells and the first slice of each tile. Both are kept in a pyramid, so that something
/// near, which covers many tiles, is looked up or noted in a few coarse ones.
template <int Dim>
class Horizon {
 public:
    using Slice = std::uint16_t;
    static constexpr Slice kNever = std::numeric_limits<Slice>::max();

    /// No rays yet. \param origin of the rays [units]
    void reset(const DirectionTiles<Dim>& tiles, const Units<Dim>& origin);

    void addRay(std::uint32_t tile, Extent extent) {
        if (tile == tiles_.lone()) return;
        const std::uint32_t kind = tile / perKind_;
        if ((used_ >> kind & 1) == 0) use(kind);
        reach_[tile] = largest(reach_[tile], extent);
    }
    /// After the last ray, before the first question.
    void completeReach();

    /// Whether a ray may visit a cell in these inclusive bounds.
    bool reaches(const Cell<Dim>& lowest, const Cell<Dim>& highest) const;

    /// Forgets what was noted: no ray has anything to tell, or each from the
    /// beginning on.
    void clear();
    void openAll();
    /// Notes that rays have something to tell at a cell.
    void open(const Cell<Dim>& cell);
    /// After the last open(), before the first firstOpen().
    void completeOpen();
    /// The first slice in which a ray of the tile has something to tell; kNever if
    /// none.
    Slice firstOpen(std::uint32_t tile) const { return open_[tile]; }

 private:
    /// Tiles of a kind that see a box of cells, and its first slice.
    struct Footprint {
        std::uint32_t kind;
        Slice slice;
        Extent extent;  ///< of the nearest cell
        std::uint32_t low[2], high[2];  ///< per minor axis
    };
    template <typename Visit>
    void forEachFootprint(const Cell<Dim>& lowest, const Cell<Dim>& highest,
                          const Visit& visit) const;
    template <typename Visit>
    bool anyTile(const Footprint& f, int level, const Visit& visit) const;
    void use(std::uint32_t kind);
    static Extent largest(Extent a, Extent b) { return a > b ? a : b; }
    static bool within(Extent a, Extent b) {
        const auto beyond = (std::uint64_t)(a > b);
        return beyond == 0;
    }

    DirectionTiles<Dim> tiles_;
    std::uint32_t perKind_ = 0;
    std::uint32_t used_ = 0;  // bit per kind
    Cell<Dim> sensor_{};
    float within_[Dim] = {};  // of the origin in its cell
    std::vector<std::uint32_t> levelBegin_;
    std::vector<Extent> reach_;  // largest, axis by axis
    std::vector<Slice> open_;
};

}  // namespace superray
