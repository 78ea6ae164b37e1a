#pragma once
// The horizon of a scan: for each tile of directions, how far rays get there, and
// from where on they have something to tell.

#include <superray/core/block.h>
#include <superray/core/ray_line.h>

#include "skipping/horizon_view.h"
#include "directions/ray_directions.h"
#include "memory/scratch_array.h"
#include "threads/surprise.h"

#include <algorithm>
#include <vector>

namespace superray {

/// The farthest cells and the first slice of each tile. Both are kept in a pyramid, so that
/// something near, which covers many tiles, is looked up or noted in a few coarse ones.
template <int Dim>
class Horizon {
 public:
    using Slice = superray::Slice;
    static constexpr Slice kNever = kNoSlice;

    /// No rays yet. \param origin of the rays [units]
    void reset(const DirectionTiles<Dim>& tiles, const Units<Dim>& origin);

    /// Adds some of the rays of `directions`, and all kinds of them.
    void addRays(const RayDirections<Dim>& directions, const std::uint32_t* rays,
                 std::size_t count);
    /// Tiles in which rays leave the sensor's cell.
    std::size_t tilesWithRays() const { return tilesWithRays_; }
    /// After the last ray, before the first question.
    void completeReach();

    /// Whether a ray may visit a cell of the block, and has nothing to tell before.
    bool reaches(const BlockKey<Dim>& block) const;

    /// Forgets what was noted: no ray has anything to tell, or each from the
    /// beginning on.
    void clear();
    void openAll();
    /// Notes that rays have something to tell at these cells of a block.
    void open(const BlockKey<Dim>& block, const BlockMask<Dim>& cells);
    /// After the last open(), before the first question about it.
    void completeOpen();
    /// The first slice in which a ray of the spot may have something to tell; kNever if
    /// none.
    Slice firstOpen(std::uint32_t spot) const {
        const Opening opening = open_[DirectionTiles<Dim>::tileOf(spot)];
        return opening.opens(spot) ? opening.slice() : kNever;
    }
    /// Of all tiles.
    const Opening* openings() const { return open_.data(); }

 private:
    template <typename Visit>
    void forEachSight(const BlockKey<Dim>& block, const Visit& visit) const;
    void fillOpenings(Opening opening);
    void completeLimits();
    template <typename Value, typename Join>
    void raise(Value* kind, const Join& join) const;
    template <Branches branches>
    std::size_t addInTurns(const RayDirections<Dim>& directions, const std::uint32_t* rays,
                           std::size_t count);
    void use(std::uint32_t kinds);

    DirectionTiles<Dim> tiles_;
    std::uint32_t perKind_ = 0;
    std::size_t tilesWithRays_ = 0;
    Surprise reachGrows_;
    std::uint32_t used_ = 0;  // bit per kind
    Cell<Dim> sensor_{};
    float within_[Dim] = {};  // of the origin in its cell
    std::vector<std::uint32_t> levelBegin_;
    // Only kinds that are used are initialised.
    ScratchArray<Extent> reach_;  // largest, axis by axis
    ScratchArray<Opening> open_;
    /// The farthest slice that rays reach and that is not behind open cells in all spots,
    /// + 1.
    ScratchArray<Slice> limit_;
    std::uint32_t opened_ = 0;  // tiles since the limits were computed
};

}  // namespace superray
