// SPDX-License-Identifier: BSD-3-Clause
// The memory bound and the sliding window.

#include <superray/core/reference_mapper.h>
#include <superray/maps/super_ray_map_base.h>
#include <superray/storage/memory_limit_error.h>

#include <algorithm>

#include "views/voxel_view.h"

namespace superray {
namespace {

constexpr std::size_t kMebi = std::size_t{1} << 20;

/// E.g. "12.3 MB".
std::string megabytes(std::size_t bytes) {
    const std::size_t tenths = (10 * bytes + kMebi / 2) / kMebi;
    return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " MB";
}

}  // namespace

template <int Dim>
std::size_t CSuperRayMapBase<Dim>::heldBytes() const {
    return storage_->heldBytes() + surfaceBytes() + companionBytes();
}

template <int Dim>
void CSuperRayMapBase<Dim>::requireWithin(std::uint32_t boundMegabytes, std::size_t needed,
                                          const char* what) const {
    const std::size_t limit = boundMegabytes * kMebi;
    if (boundMegabytes == 0 || needed <= limit) return;
    const std::size_t held = heldBytes();
    throw MemoryLimitError(
        limit, held, needed,
        shortClassName() + ": " + what + " would take up to " + megabytes(needed) +
            " of memory; max_memory_megabytes = " + std::to_string(boundMegabytes) +
            ", the map holds " + megabytes(held) +
            " and stays as it is. A coarser resolution, a shorter maxrange or a windowRadius "
            "needs less; or raise the bound");
}

template <int Dim>
void CSuperRayMapBase<Dim>::requireRoomFor(const WrittenBlocks& written,
                                           std::size_t surfaceBytes, const char* what) const {
    requireWithin(maxMegabytes_,
                  storage_->heldBytesWith(written) + surfaceBytes + companionBytesWith(written),
                  what);
}

template <int Dim>
std::size_t CSuperRayMapBase<Dim>::surfaceBytesAtMost(std::size_t newCells) const {
    if (!insertionOptions.pointStatistics) return surfaceBytes();
    return surface_ ? surface_->memoryBytesAtMost(newCells)
                    : SurfaceStatistics<Dim>(storage_->geometry()).memoryBytesAtMost(newCells);
}

template <int Dim>
std::size_t CSuperRayMapBase<Dim>::surfaceBytesWith(const RayBundle<Dim>& rays) const {
    const bool isLookedUp = insertionOptions.pointStatistics && surface_;
    return surfaceBytesAtMost(isLookedUp ? surface_->newCells(rays) : rays.size());
}

template <int Dim>
unsigned CSuperRayMapBase<Dim>::requireRoom(const UpdateBatch<Dim>& batch,
                                            const RayBundle<Dim>& rays) const {
    const unsigned threads = insertionOptions.threads;
    if (maxMegabytes_ == 0) return threads;
    // Far from the bound, as nearly always, that is soon told.
    const std::size_t blocks = batch.blockCount();
    if (storage_->heldBytesAtMost(blocks, threads) + surfaceBytesAtMost(rays.size()) +
            companionBytesAtMost(blocks) <=
        maxMegabytes_ * kMebi)
        return threads;
    requireRoomFor(
        [&](const typename OccupancyMap<Dim>::BlockVisitor& visit) {
            storage_->forEachWritten(batch, sensorModel(), insertionOptions.policy, visit);
        },
        surfaceBytesWith(rays), "this scan");
    return 1;  // what was foretold holds for one thread
}

template <int Dim>
void CSuperRayMapBase<Dim>::requireRoom(const CellCountMap<Dim>& counts,
                                        const RayBundle<Dim>& rays) const {
    if (maxMegabytes_ == 0) return;
    requireRoomFor(
        [&](const typename OccupancyMap<Dim>::BlockVisitor& visit) {
            storage_->forEachWritten(counts, sensorModel(), insertionOptions.policy, visit);
        },
        surfaceBytesWith(rays), "this scan");
}

template <int Dim>
typename CSuperRayMapBase<Dim>::BlockKeys CSuperRayMapBase<Dim>::slideWindow(
    const BlockWindow<Dim>& window) {
    if (surface_) makeOwnStatistics();
    BlockKeys forgotten;
    try {
        storage_.writable().forgetOutside(
            window, [&](const BlockKey<Dim>& key) { forgotten.push_back(key); });
    } catch (...) {
        if (surface_) surface_->forgetOutside(window);
        throw;
    }
    if (surface_) surface_->forget(forgotten, window);
    for (const BlockKey<Dim>& key : forgotten) changes_.add(key);
    view_->forgotten(forgotten);
    return forgotten;
}

#define SUPERRAY_INSTANTIATE(Dim)                                                              \
    template std::size_t CSuperRayMapBase<Dim>::heldBytes() const;                             \
    template void CSuperRayMapBase<Dim>::requireWithin(std::uint32_t, std::size_t,             \
                                                       const char*) const;                     \
    template void CSuperRayMapBase<Dim>::requireRoomFor(const WrittenBlocks&, std::size_t,     \
                                                        const char*) const;                    \
    template std::size_t CSuperRayMapBase<Dim>::surfaceBytesAtMost(std::size_t) const;         \
    template std::size_t CSuperRayMapBase<Dim>::surfaceBytesWith(const RayBundle<Dim>&) const; \
    template unsigned CSuperRayMapBase<Dim>::requireRoom(const UpdateBatch<Dim>&,              \
                                                         const RayBundle<Dim>&) const;         \
    template void CSuperRayMapBase<Dim>::requireRoom(const CellCountMap<Dim>&,                 \
                                                     const RayBundle<Dim>&) const;             \
    template CSuperRayMapBase<Dim>::BlockKeys CSuperRayMapBase<Dim>::slideWindow(              \
        const BlockWindow<Dim>&);
SUPERRAY_INSTANTIATE(2)
SUPERRAY_INSTANTIATE(3)
#undef SUPERRAY_INSTANTIATE

}  // namespace superray
