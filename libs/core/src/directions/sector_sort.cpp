// SPDX-License-Identifier: BSD-3-Clause
#include "directions/sector_sort.h"

#include <superray/core/detail/parallel.h>

#include <algorithm>

namespace superray {

/// A counting sort: counts per chunk and sector become the places where the rays go.
template <int Dim>
const RayBundle<Dim>& SectorSort<Dim>::sorted(const RayBundle<Dim>& rays, std::size_t chunks,
                                              const BlockDirectory<Dim>& directory,
                                              ClassifyRays<Dim> classifyRays) {
    if (chunks_.size() < chunks) chunks_.resize(chunks);
    const std::size_t count = rays.size();
    inParallel(chunks, [&](std::size_t c) {
        findSectors(rays, chunkBegin(count, c, chunks), chunkBegin(count, c + 1, chunks),
                    directory, classifyRays, chunks_[c]);
    });
    std::size_t begin = 0;
    for (std::size_t sector = 0; sector < kSectors; ++sector) {
        for (std::size_t c = 0; c < chunks; ++c) {
            const std::size_t n = chunks_[c].rays[sector];
            chunks_[c].rays[sector] = begin;
            begin += n;
        }
    }
    if (!sorted_) sorted_.emplace(rays.geometry(), rays.commonOrigin());
    sorted_->restartLike(rays);
    inParallel(chunks, [&](std::size_t c) {
        std::size_t ray = chunkBegin(count, c, chunks);
        for (const std::uint8_t sector : chunks_[c].sectors)
            sorted_->place(chunks_[c].rays[sector]++, rays, ray++);
    });
    return *sorted_;
}

/// Finds the sectors of the rays [first, last), and how many rays each has.
template <int Dim>
void SectorSort<Dim>::findSectors(const RayBundle<Dim>& rays, std::size_t first,
                                  std::size_t last, const BlockDirectory<Dim>& directory,
                                  ClassifyRays<Dim> classifyRays, Chunk& chunk) const {
    constexpr std::size_t kMost = ClassifiedBatch<Dim>::kMost;
    DirectionBins<Dim> bins;
    ClassifiedBatch<Dim> batch;
    std::array<std::uint32_t, kMost + ClassifiedBatch<Dim>::kSlack> subBin;
    std::array<std::uint16_t, kMost + ClassifiedBatch<Dim>::kSlack> lastSlice;
    chunk.sectors.resize(last - first);
    chunk.rays.fill(0);
    for (std::size_t at = first; at < last; at += kMost) {
        const std::size_t n = std::min(kMost, last - at);
        classifyRays(rays, at, n, directory, bins, subBin.data(), lastSlice.data(), batch);
        for (std::size_t i = 0; i < n; ++i) {
            const std::uint32_t sector = bins.sectorOf(subBin[i]);
            chunk.sectors[at - first + i] = static_cast<std::uint8_t>(sector);
            ++chunk.rays[sector];
        }
    }
}

template class SectorSort<2>;
template class SectorSort<3>;

}  // namespace superray
