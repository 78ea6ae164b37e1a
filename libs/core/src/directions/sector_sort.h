// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Rays of a scan, ordered by sector for several threads.

#include <superray/core/ray_bundle.h>

#include "counting/block_directory.h"
#include "directions/classified_batch.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace superray {

/// Copies scans so that rays of one sector are neighbours, in the sensor's order. Threads that
/// take chunks of the copy go different ways, so few blocks are counted by several of them.
template <int Dim>
class SectorSort {
 public:
    /// A sorted copy of the scan, valid until the next call.
    /// \param chunks threads that sort
    /// \param directory covers the scan
    /// \param classifyRays kernel
    /// \pre the rays have a common origin
    const RayBundle<Dim>& sorted(const RayBundle<Dim>& rays, std::size_t chunks,
                                 const BlockDirectory<Dim>& directory,
                                 ClassifyRays<Dim> classifyRays);

 private:
    /// Sectors, and one for unclassified rays.
    static constexpr std::size_t kSectors = DirectionBins<Dim>::kSectors + 1;

    struct Chunk {
        std::vector<std::uint8_t> sectors;         // of its rays
        std::array<std::size_t, kSectors> rays{};  // per sector: how many; then where they go
    };
    void findSectors(const RayBundle<Dim>& rays, std::size_t first, std::size_t last,
                     const BlockDirectory<Dim>& directory, ClassifyRays<Dim> classifyRays,
                     Chunk& chunk) const;

    std::vector<Chunk> chunks_;
    std::optional<RayBundle<Dim>> sorted_;
};

}  // namespace superray
