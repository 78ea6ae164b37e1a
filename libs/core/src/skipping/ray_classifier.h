// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Classifies the rays of a chunk, and builds the direction ranges from them.

#include "skipping/hit_counter.h"
#include "skipping/skipping_scan.h"

#include <array>

namespace superray {

/// Stages 1 and 2 in one pass over batches of rays that stay in the L1 cache: reading the
/// rays of a coarse map twice takes longer than everything else that is done with them.
/// Keeps its buffers from scan to scan.
template <int Dim>
class RayClassifier {
 public:
    /// Classifies the rays of a chunk, counts their hits, and builds their ranges.
    /// \param counts of the thread; cells that hits alone saturate need no misses afterwards
    /// \param rays,ranges overwritten
    void classify(const SkippingScan<Dim>& scan, RayChunk chunk, ScanCounts<Dim>& counts,
                  ClassifiedRays<Dim>& rays, DirectionRanges<Dim>& ranges);

 private:
    ClassifiedBatch<Dim> batch_;
    std::array<std::uint32_t, ClassifiedBatch<Dim>::kMost + ClassifiedBatch<Dim>::kSlack>
        runStarts_;
    HitCounter<Dim> hitCounter_;
};

}  // namespace superray
