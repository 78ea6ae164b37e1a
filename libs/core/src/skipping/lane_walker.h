// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The walk of chosen rays, several side by side.

#include "skipping/skipping_scan.h"

#include <array>

namespace superray {

/// Walks pieces of jobs, this thread's or another's, into this thread's counts. Rays of one
/// sector wait for each other until a vector register is full of them.
template <int Dim>
class LaneWalker {
 public:
    /// \param scan,counts must outlive the walks of this scan
    void start(const SkippingScan<Dim>& scan, ScanCounts<Dim>& counts);

    /// Counts the free cells of the chosen rays of a piece, each from its first slice that
    /// may change the map. Some of them wait until flush().
    void walk(const WalkJob<Dim>& job, WorkPiece piece);

    /// Walks the rays that still wait, and counts all addresses.
    void flush();

    /// Rays since start() that were walked in full, from slice 0 on.
    std::uint64_t walkedInFull() const { return walkedInFull_; }

 private:
    void walkUnclassified(std::size_t ray);
    void walkLanes(RayLanes& lanes, WalkRays<Dim> kernel);

    const SkippingScan<Dim>* scan_ = nullptr;
    ScanCounts<Dim>* counts_ = nullptr;
    WalkKernels<Dim> kernels_;
    /// Per sector, rays that wait: [0] with many, [1] with few slices left.
    std::array<std::array<RayLanes, 2>, DirectionBins<Dim>::kSectors> waiting_;
    std::uint64_t walkedInFull_ = 0;
};

}  // namespace superray
