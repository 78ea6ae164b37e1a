// SPDX-License-Identifier: BSD-3-Clause
#include "skipping/hit_counter.h"

#include "threads/interleave.h"

namespace superray {

template <int Dim>
void HitCounter<Dim>::count(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays,
                            std::size_t first, const ClassifiedBatch<Dim>& batch,
                            const std::uint32_t* runStarts, std::size_t runs) {
    if (counts.directory.dense()) {
        findOffsets(counts, rays, first, batch, runStarts, runs);
        hitsMatter_.learn(hitsMatter_.unpredictable()
                              ? countInterleaved<Branches::none>(counts, runStarts, runs)
                              : countInterleaved<Branches::predicted>(counts, runStarts, runs),
                          runs);
        return;
    }
    // A batch has no block indices then: cell by cell.
    for (std::size_t i = first; i < first + runStarts[runs]; ++i) {
        if (rays.kind(i) != RayEnd::hit) continue;
        const Cell<Dim> cell = rays.geometry().cellOf(rays.end(i));
        const auto local = static_cast<std::uint32_t>(indexInBlock<Dim>(cell));
        const std::uint32_t offset = counts.hitOffset(blockOf<Dim>(cell)) + local;
        std::uint8_t& hits = counts.batch.hitArena()[offset];
        if (hits < counts.mostHits()) ++hits;
    }
}

/// Finds where the hits of each run are counted. A loop of its own: looking up blocks then
/// need not wait for counts that are not in the cache.
template <int Dim>
void HitCounter<Dim>::findOffsets(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays,
                                  std::size_t first, const ClassifiedBatch<Dim>& batch,
                                  const std::uint32_t* runStarts, std::size_t runs) {
    const RayEnd* const ends = rays.kinds() + first;
    for (std::size_t run = 0; run < runs; ++run) {
        const std::size_t i = runStarts[run];
        if (ends[i] != RayEnd::hit) {
            offsets_[run] = ScanCounts<Dim>::kNoOffset;
            continue;
        }
        const std::uint32_t block = counts.hitOffset(batch.block[i], [&] {
            return blockOf<Dim>(rays.geometry().cellOf(rays.end(first + i)));
        });
        offsets_[run] = block + batch.local[i];
    }
}

/// Counts the runs. Interleaved, since neighbours often end in the same cell.
/// \return how many runs changed a count
template <int Dim>
template <Branches branches>
std::size_t HitCounter<Dim>::countInterleaved(ScanCounts<Dim>& counts,
                                              const std::uint32_t* runStarts,
                                              std::size_t runs) const {
    std::uint8_t* const arena = counts.batch.hitArena();
    const std::uint8_t enough = counts.mostHits();
    std::size_t changes = 0;
    interleave(runs, [&](std::size_t, std::size_t run) {
        if (offsets_[run] == ScanCounts<Dim>::kNoOffset) return;
        std::uint8_t& hits = arena[offsets_[run]];
        const bool change = hits < enough;
        changes += change;
        if (branches == Branches::none || change)
            hits = ScanCounts<Dim>::saturatingAdd(hits, runStarts[run + 1] - runStarts[run]);
    });
    return changes;
}

template class HitCounter<2>;
template class HitCounter<3>;

}  // namespace superray
