#include "skipping/hit_counter.h"

#include "threads/in_turns.h"

namespace superray {

template <int Dim>
void HitCounter<Dim>::count(WalkState<Dim>& state, const RayBundle<Dim>& rays,
                            std::size_t first, const RayDirections<Dim>& directions,
                            const std::uint32_t* starts, std::size_t runs) {
    if (state.directory.dense()) {
        findPlaces(state, rays, first, directions, starts, runs);
        hitsMatter_.learn(hitsMatter_.unpredictable()
                              ? countInTurns<Branches::none>(state, starts, runs)
                              : countInTurns<Branches::predicted>(state, starts, runs),
                          runs);
        return;
    }
    for (std::size_t i = first; i < first + starts[runs]; ++i) {
        if (rays.kind(i) != RayEnd::hit) continue;
        const Cell<Dim> cell = rays.geometry().cellOf(rays.end(i));
        const auto local = static_cast<std::uint32_t>(indexInBlock<Dim>(cell));
        const std::uint32_t place = state.hitPlace(blockOf<Dim>(cell)) + local;
        std::uint8_t& hits = state.batch.hitArena()[place];
        if (hits < state.sureHits()) ++hits;
    }
}

/// Finds where the hits of the runs are counted. To count while at it would take longer:
/// looking up blocks need not wait for counts that are not in the cache.
template <int Dim>
void HitCounter<Dim>::findPlaces(WalkState<Dim>& state, const RayBundle<Dim>& rays,
                                 std::size_t first, const RayDirections<Dim>& directions,
                                 const std::uint32_t* starts, std::size_t runs) {
    const RayEnd* const ends = rays.kinds() + first;
    for (std::size_t run = 0; run < runs; ++run) {
        const std::size_t i = starts[run];
        if (ends[i] != RayEnd::hit) {
            places_[run] = WalkState<Dim>::kNoPlace;
            continue;
        }
        const std::uint32_t block = state.hitPlace(directions.block[i], [&] {
            return blockOf<Dim>(rays.geometry().cellOf(rays.end(first + i)));
        });
        places_[run] = block + directions.local[i];
    }
}

/// Neighbours often end in the same cell.
/// \return number of runs whose hits changed something
template <int Dim>
template <Branches branches>
std::size_t HitCounter<Dim>::countInTurns(WalkState<Dim>& state, const std::uint32_t* starts,
                                          std::size_t runs) const {
    std::uint8_t* const arena = state.batch.hitArena();
    const std::uint8_t sure = state.sureHits();
    std::size_t changes = 0;
    inTurns(runs, [&](std::size_t, std::size_t run) {
        if (places_[run] == WalkState<Dim>::kNoPlace) return;
        std::uint8_t& hits = arena[places_[run]];
        const bool change = hits < sure;
        changes += change;
        if (branches == Branches::none || change)
            hits = WalkState<Dim>::saturatingAdd(hits, starts[run + 1] - starts[run]);
    });
    return changes;
}

template class HitCounter<2>;
template class HitCounter<3>;

}  // namespace superray
