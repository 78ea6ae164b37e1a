// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Hits of a scan's rays, run by run.

#include "kernels/walk_kernel.h"
#include "threads/branch_choice.h"

#include <array>
#include <cstdint>

namespace superray {

/// Counts hits in a batch, as far as more of them may change something.
template <int Dim>
class HitCounter {
 public:
    /// Counts the hits of some rays from `first` on, at most ClassifiedBatch::kMost.
    /// \param directions of these rays
    /// \param starts where runs of rays begin that end alike; one more: where the last ends
    void count(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays, std::size_t first,
               const ClassifiedBatch<Dim>& directions, const std::uint32_t* starts,
               std::size_t runs);

 private:
    void findOffsets(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays, std::size_t first,
                     const ClassifiedBatch<Dim>& directions, const std::uint32_t* starts,
                     std::size_t runs);
    template <Branches branches>
    std::size_t countInterleaved(ScanCounts<Dim>& counts, const std::uint32_t* starts,
                                 std::size_t runs) const;

    /// Per run: where its hits are counted, or ScanCounts::kNoOffset.
    std::array<std::uint32_t, ClassifiedBatch<Dim>::kMost> offsets_;
    BranchChoice hitsMatter_;
};

}  // namespace superray
