// SPDX-License-Identifier: BSD-3-Clause
#include "skipping/hit_counter.h"

#include "threads/interleave.h"

namespace superray {

template <int Dim>
void HitCounter<Dim>::count(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays,
                            std::size_t first, const ClassifiedBatch<Dim>& directions,
                            const std::uint32_t* starts, std::size_t runs) {
    if (counts.directory.dense()) {
        findOffsets(counts, rays, first, directions, starts, runs);
        hitsMatter_.learn(hitsMatter_.unpredictable()
                              ? countInterleaved<Branches::none>(counts, starts, runs)
                              : countInterleaved<Branches::predicted>(counts, starts, runs),
                          runs);
        return;
    }
    for (std::size_t i = first; i < first + starts[runs]; ++i) {
        if (rays.kind(i) != RayEnd::hit) continue;
        const Cell<Dim> cell = rays.geometry().cellOf(rays.end(i));
        const auto local = static_cast<std::uint32_t>(indexInBlock<Dim>(cell));
        const std::uint32_t offset = counts.hitOffset(blockOf<Dim>(cell)) + local;
        std::uint8_t& hits = counts.batch.hitArena()[offset];
        if (hits < counts.hitsToSaturate()) ++hits;
    }
}

/// Finds where the hits of the runs are counted. To count while at it would take longer:
/// looking up blocks need not wait for counts that are not in the cache.
template <int Dim>
void HitCounter<Dim>::findOffsets(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays,
                                  std::size_t first, const ClassifiedBatch<Dim>& directions,
                                  const std::uint32_t* starts, std::size_t runs) {
    const RayEnd* const ends = rays.kinds() + first;
    for (std::size_t run = 0; run < runs; ++run) {
        const std::size_t i = starts[run];
        if (ends[i] != RayEnd::hit) {
            offsets_[run] = ScanCounts<Dim>::kNoOffset;
            continue;
        }
        const std::uint32_t block = counts.hitOffset(directions.block[i], [&] {
            return blockOf<Dim>(rays.geometry().cellOf(rays.end(first + i)));
        });
        offsets_[run] = block + directions.local[i];
    }
}

/// Neighbours often end in the same cell.
/// \return number of runs whose hits changed something
template <int Dim>
template <Branches branches>
std::size_t HitCounter<Dim>::countInterleaved(ScanCounts<Dim>& counts,
                                              const std::uint32_t* starts,
                                              std::size_t runs) const {
    std::uint8_t* const arena = counts.batch.hitArena();
    const std::uint8_t sure = counts.hitsToSaturate();
    std::size_t changes = 0;
    interleave(runs, [&](std::size_t, std::size_t run) {
        if (offsets_[run] == ScanCounts<Dim>::kNoOffset) return;
        std::uint8_t& hits = arena[offsets_[run]];
        const bool change = hits < sure;
        changes += change;
        if (branches == Branches::none || change)
            hits = ScanCounts<Dim>::saturatingAdd(hits, starts[run + 1] - starts[run]);
    });
    return changes;
}

template class HitCounter<2>;
template class HitCounter<3>;

}  // namespace superray
