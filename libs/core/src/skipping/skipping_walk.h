// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Method `auto`: walks each ray only from where it may still change the map.

#include "skipping/lane_walker.h"
#include "skipping/ray_classifier.h"
#include "skipping/ray_sample.h"
#include "skipping/settled_region.h"
#include "tuning.h"

#include <memory>
#include <vector>

namespace superray {

/// Slices that all rays of a chunk had left to walk, before and after a sample. Zero if no
/// sample could have paid.
struct SampleEffect {
    double before = 0, after = 0;
};

/// What a chunk took, for statistics and for the chunks of the next scan.
struct ChunkReport {
    double work = 0;  ///< slices to walk, whoever walked them, or what takes as long
    SampleEffect sample;
};

/// One thread's part of a scan by empty-space skipping (doc/glossary.md has a picture).
///
/// Most cells that a ray passes are settled: another miss cannot change them. Those next to
/// the sensor form one connected region, and only its boundary cells are worth a visit.
///
///   1 classify   direction bin and last slice of each ray; hits are counted on the way.
///                Where hits matter to all, threads wait for each other here
///   2 build      per bin, the farthest end cell: the DirectionRanges
///   3 grow       the settled region around the sensor; its boundary cells that rays reach
///                are marked in the ranges, with the first slice in which they are met
///   4 sample     where it pays, some rays are walked first, and the region is grown again
///   5 select     rays that pass a marked sub-bin at or before their end
///   6 walk       these, from their bin's first slice on; idle threads take pieces
///
/// Buffers are kept from scan to scan.
template <int Dim>
class SkippingWalk {
 public:
    /// Stages 1 and 2. Counts the hits of a chunk, into `counts`.
    /// \pre counts.reset() was called for the scan
    void classify(const SkippingScan<Dim>& scan, RayChunk chunk, ScanCounts<Dim>& counts);
    /// The other stages. Counts the misses where the rays of the chunk may change the map.
    /// \pre classify() with the same arguments; scan.hitsOfAll may have been set since
    ChunkReport run(const SkippingScan<Dim>& scan, RayChunk chunk, ScanCounts<Dim>& counts);

    /// Chosen rays of this chunk, for threads that have nothing else to do.
    SharedJob<Dim>& shared() { return *shared_; }
    /// Walks pieces of another chunk, until none will come. \pre run() returned
    void help(SharedJob<Dim>& other);

    /// Rays that this thread walked in full, since run().
    std::uint64_t walkedInFull() const { return walker_.walkedInFull(); }

 private:
    /// The chunk that run() is at.
    struct Stage {
        const SkippingScan<Dim>& scan;
        RayChunk chunk;
        ScanCounts<Dim>& counts;
        ChunkReport& report;
    };

    Boundary grow(const Stage& stage);
    Boundary sample(const Stage& stage, Boundary boundary);
    double slicesLeft() const;
    std::size_t walkSample(const Stage& stage, const std::vector<std::uint32_t>& rays);
    void addWork(ChunkReport& report, std::size_t chosen, std::size_t every) const;
    std::size_t select(const Stage& stage);
    void walk(const Stage& stage, std::size_t chosen);

    RayClassifier<Dim> classifier_;
    ClassifiedRays<Dim> rays_;
    DirectionRanges<Dim> ranges_;
    SettledRegion<Dim> region_;
    RaySample smallSample_{0, SkippingCosts::kSmallSample};
    RaySample sample_{SkippingCosts::kSmallSample, SkippingCosts::kBothSamples};
    ScratchArray<std::uint32_t> chosen_;
    LaneWalker<Dim> walker_;
    std::unique_ptr<SharedJob<Dim>> shared_ = std::make_unique<SharedJob<Dim>>();
};

}  // namespace superray
