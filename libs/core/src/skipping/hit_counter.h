// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Hits of a scan's rays, run by run.

#include "counting/scan_counts.h"
#include "directions/classified_batch.h"
#include "threads/branch_choice.h"

#include <array>
#include <cstdint>

namespace superray {

/// Counts the hits of classified rays, each run of rays that end in one cell at once. Stops at
/// the number of hits that saturates a cell.
template <int Dim>
class HitCounter {
 public:
    /// Counts the hits of a batch.
    /// \param first ray of the scan that the batch begins with
    /// \param runStarts where runs begin, and one more: where the last one ends
    void count(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays, std::size_t first,
               const ClassifiedBatch<Dim>& batch, const std::uint32_t* runStarts,
               std::size_t runs);

 private:
    void findOffsets(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays, std::size_t first,
                     const ClassifiedBatch<Dim>& batch, const std::uint32_t* runStarts,
                     std::size_t runs);
    template <Branches branches>
    std::size_t countInterleaved(ScanCounts<Dim>& counts, const std::uint32_t* runStarts,
                                 std::size_t runs) const;

    /// Per run: offset of its end cell in the hit counts, or ScanCounts::kNoOffset.
    std::array<std::uint32_t, ClassifiedBatch<Dim>::kMost> offsets_;
    BranchChoice hitsMatter_;
};

}  // namespace superray
