// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Tuned numbers of the engine. They decide how much work a scan takes, never what it counts.
// Percentages are times of `superray-bench compare`, quoted from doc/experiments.md, where the
// data sets have the names used here. "Estimate" marks a number that no experiment backs.

#include <cstddef>
#include <cstdint>

namespace superray {

/// Costs and thresholds of empty-space skipping. The unit of work is a visit: the time to
/// walk one ray through one slice, 2 to 4 ns.
struct SkippingCosts {
    // Direction bins: as wide as a cell at the end of a typical ray, unless stated otherwise.

    /// Bins are twice as fine where rays per bin [rays] exceed this: 1 to 2 % of the room;
    /// with fewer rays, the hall at 0.2 m gets a sixth slower.
    static constexpr std::size_t kRaysPerFineBin = 24;
    /// Levels below this are twice as fine for any number of rays: such bins are few.
    /// Estimate.
    static constexpr int kFineLevels = 5;

    // The settled region.

    /// Most work of growing it once [visits per ray]. On sparse lidar scans its border has a
    /// million cells, which would take longer than the walks.
    static constexpr std::uint64_t kGrowthPerRay = 4;
    /// Work of coming to a block, and of spreading inside it [visits]. Estimate.
    static constexpr std::uint64_t kVisitBlock = 40, kSpreadInBlock = 40;
    /// Work of marking the boundary cells of a block, and one of them [visits].
    /// Estimate.
    static constexpr std::uint64_t kMarkBlock = 100, kMarkCell = 8;
    /// Grow the region again only if the expected saving is this many times its cost:
    /// 1 to 2 % indoors.
    static constexpr double kWorthGrowing = 4;
    /// Bins marked in all sub-bins until what is hidden behind them is computed again
    /// [bins]. Estimate.
    static constexpr std::uint32_t kMarksPerUpdate = 4096;

    // Samples: rays walked first, so that the others are spared what these saturate.

    /// The first, small sample [part of all rays]. 0.12 to 0.5 of 37 are alike.
    static constexpr double kSmallSample = 1.0 / 148;
    /// Both samples together: 2 or 7 of 37 are 5 to 15 % slower in the room.
    static constexpr double kBothSamples = 4.0 / 37;
    /// Rays per bin above which a sample can pay: with fewer, rays that are walked out of
    /// the sensor's order miss the cache more than they save.
    static constexpr double kDense = 3.5;
    /// Rays per bin above which the sample itself is worth a sample: a sixth of the room
    /// at 2 and 5 cm.
    static constexpr double kVeryDense = 16;
    /// Fewest rays of a sample that may settle the cells around the sensor [rays]: as many
    /// misses as take any cell to the lower clamp with the default sensor model, and one.
    static constexpr std::size_t kLeastSample = 16;
    /// A sample pays if the others have less than this part of their slices left. If not,
    /// the next scans do without (Backoff): 5 to 8 % of KITTI.
    static constexpr double kSamplePays = 0.75;
    /// Every so many rays, one is asked how many slices it has left [rays]: a prime, so
    /// that rows and columns of an image all get asked. Estimate.
    static constexpr std::size_t kEstimateEvery = 101;

    // The walk.

    /// Rays with fewer slices left are walked side by side: 8 to 12 % of a scan.
    static constexpr std::int32_t kFewSlices = 6;
    /// Prefetch distance of end points [chosen rays]. Estimate.
    static constexpr std::size_t kPrefetchAhead = 32;
    /// Work of a ray before it is walked, for equal chunks: classification, hits [visits].
    /// Estimate: 8 to 15 ns a ray in coarse maps.
    static constexpr double kWorkOfAnyRay = 8;
    /// Every so many chosen rays, one tells the work of a chunk for all [rays]. Estimate.
    static constexpr std::size_t kWorkEvery = 16;
};

/// Thresholds of counting and of sharing it out to threads.
struct CountingCosts {
    /// Addresses gathered before they are counted: enough to keep the counting loop free of
    /// mispredictions, few enough to stay in the L1 cache (8 KiB). Estimate.
    static constexpr std::size_t kFlushAt = 2048;
    /// Fewest rays per thread [rays]. Estimate: starting a pooled thread takes 3 to 90 us.
    static constexpr std::size_t kRaysPerChunk = 256;
    /// Fewest blocks per thread when counts of threads are added [blocks]. Estimate.
    static constexpr std::size_t kBlocksPerChunk = 512;
    /// Typical length from which on scans that go all around are sorted by direction before
    /// threads share them [cells]: 8 to 18 % of KITTI; shorter rays do not pay for it.
    static constexpr double kLongRay = 64;
    /// Fewest points per thread when points are copied into a bundle [points]. Estimate.
    static constexpr std::size_t kPointsPerChunk = std::size_t{1} << 14;
    /// Points copied at once, or one by one if any of them is not addressable [points]:
    /// small enough to stay in the L1 cache. Estimate.
    static constexpr std::size_t kPointsAtOnce = 512;
};

}  // namespace superray
