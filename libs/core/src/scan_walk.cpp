// SPDX-License-Identifier: BSD-3-Clause
#include "scan_walk.h"

#include <superray/core/detail/parallel.h>

#include "counting/merge_counts.h"
#include "paper/ray_walker.h"
#include "tuning.h"

namespace superray {
namespace {

/// Whether several threads should take rays by sector: those of a lidar that are long enough
/// to pass many blocks.
template <int Dim>
bool sortingPays(const RayBundle<Dim>& rays, std::size_t threads) {
    return threads > 1 && goAllAround(rays) &&
           typicalLength(rays, 0, rays.size()) > CountingCosts::kLongRay;
}

}  // namespace

/// Chooses how many workers share a scan.
template <int Dim>
void ScanWalk<Dim>::start(std::size_t rays, unsigned threads) {
    used_ = chunkCountFor(rays, CountingCosts::kRaysPerChunk, threads);
    if (workers_.size() < used_) workers_.resize(used_);
    for (Worker& worker : workers_) worker.culled = 0;
}

/// Looks up the end cells of all rays, and counts hits.
template <int Dim>
void ScanWalk<Dim>::countEndCells(const RayBundle<Dim>& rays, const ScanBounds<Dim>& bounds) {
    inParallel(used_, [&](std::size_t w) {
        Worker& worker = workers_[w];
        worker.counts.reset(bounds.blocks());
        worker.ends.assign(rays, chunkBegin(rays.size(), w, used_),
                           chunkBegin(rays.size(), w + 1, used_), bounds.blocks());
        worker.ends.addHits(worker.counts);
    });
}

template <int Dim>
auto ScanWalk<Dim>::walkSuperRays(const RayBundle<Dim>& rays, const ScanBounds<Dim>& bounds,
                                  unsigned threads, const std::vector<SuperRay>& superRays,
                                  const CullingRegion<Dim>& region) -> Result {
    start(rays.size(), threads);
    countEndCells(rays, bounds);
    inParallel(used_, [&](std::size_t w) {
        RayWalker<Dim> walker(workers_[w].counts, rays, region);
        const std::size_t end = chunkBegin(superRays.size(), w + 1, used_);
        for (std::size_t i = chunkBegin(superRays.size(), w, used_); i < end; ++i)
            walker.walk(superRays[i].ray, superRays[i].weight);
        workers_[w].culled = walker.culled();
    });
    return sum();
}

template <int Dim>
auto ScanWalk<Dim>::walkEach(const RayBundle<Dim>& rays, const ScanBounds<Dim>& bounds,
                             unsigned threads, const CullingRegion<Dim>& region) -> Result {
    start(rays.size(), threads);
    countEndCells(rays, bounds);
    const bool culling = !region.empty() && rays.hasCommonOrigin();
    inParallel(used_, [&](std::size_t w) {
        Worker& worker = workers_[w];
        if (culling) worker.ends.findEnclosed(region);
        RayWalker<Dim> walker(worker.counts, rays, region);
        const std::size_t end = chunkBegin(rays.size(), w + 1, used_);
        for (std::size_t i = chunkBegin(rays.size(), w, used_); i < end; ++i) {
            if (culling && worker.ends.enclosed(i))
                ++worker.culled;
            else
                walker.walk(i, 1);
        }
        worker.culled += walker.culled();
    });
    return sum();
}

template <int Dim>
auto ScanWalk<Dim>::walkSkipping(const RayBundle<Dim>& rays, const ScanBounds<Dim>& bounds,
                                 unsigned threads, const SaturationSource<Dim>* map,
                                 const SaturationLimits& limits) -> Result {
    start(rays.size(), threads);
    const bool sorting = sortingPays(rays, used_);
    if (sorting) workers_[0].counts.reset(bounds.blocks());
    const RayBundle<Dim>& walked = sorting
                                       ? sort_.sorted(rays, used_, workers_[0].counts.directory,
                                                      bestKernels<Dim>().classifyRays)
                                       : rays;
    SkippingScan<Dim> scan(walked, map, limits, sampling());
    balancer_.begin(used_);
    const auto chunkOf = [&](std::size_t w) {
        return RayChunk{balancer_.first(rays.size(), w), balancer_.first(rays.size(), w + 1)};
    };
    inParallel(used_, [&](std::size_t w) {
        Worker& worker = workers_[w];
        worker.counts.reset(bounds.blocks());
        worker.skipping.classify(scan, chunkOf(w), worker.counts);
    });
    if (limits.hitsUnsettle && used_ > 1) shareHits(scan);
    std::vector<ChunkReport> reports(used_);
    inParallel(used_, [&](std::size_t w) {
        Worker& worker = workers_[w];
        const RayChunk chunk = chunkOf(w);
        reports[w] = worker.skipping.run(scan, chunk, worker.counts);
        for (std::size_t i = 1; i < used_; ++i)
            worker.skipping.help(workers_[(w + i) % used_].skipping.shared());
        // In sum, the rays that were not walked in full; a summand may wrap around.
        worker.culled = chunk.size() - worker.skipping.walkedInFull();
    });
    learn(reports);
    return sum();
}

/// Lets every thread see the hits of all.
template <int Dim>
void ScanWalk<Dim>::shareHits(SkippingScan<Dim>& scan) {
    inParallel(used_, [&](std::size_t w) { workers_[w].hitBlocks.assign(workers_[w].counts); });
    hitsOfAll_.clear();
    for (std::size_t w = 0; w < used_; ++w) hitsOfAll_.add(workers_[w].hitBlocks);
    scan.hitsOfAll = &hitsOfAll_;
}

/// Samples are tried now and then, and as long as they pay.
template <int Dim>
Sampling ScanWalk<Dim>::sampling() {
    return samplePays_.tryNow() ? Sampling::whereItMayPay : Sampling::never;
}

/// Learns from a scan: equal work for each worker in the next one, and whether samples pay.
template <int Dim>
void ScanWalk<Dim>::learn(const std::vector<ChunkReport>& reports) {
    SampleEffect effect;
    std::vector<double> work;
    for (const ChunkReport& report : reports) {
        effect.before += report.sample.before;
        effect.after += report.sample.after;
        work.push_back(report.work);
    }
    balancer_.learn(work);
    if (effect.before > 0)
        samplePays_.learn(effect.after < SkippingCosts::kSamplePays * effect.before);
}

/// Adds the counts of all workers to those of the first.
template <int Dim>
auto ScanWalk<Dim>::sum() -> Result {
    std::uint64_t culled = 0;
    for (std::size_t w = 0; w < used_; ++w) culled += workers_[w].culled;
    for (std::size_t w = 1; w < used_; ++w)
        mergeCounts(workers_[0].counts, workers_[w].counts,
                    w + 1 == used_ ? NewBlocks::borrowed : NewBlocks::copied, used_);
    return {workers_[0].counts, culled};
}

template <int Dim>
void ScanWalk<Dim>::reserve(std::size_t bytes, unsigned threads) {
    if (workers_.size() < threads) workers_.resize(threads);
    for (std::size_t w = 0; w < threads; ++w) workers_[w].counts.batch.reserve(bytes / threads);
}

template class ScanWalk<2>;
template class ScanWalk<3>;

}  // namespace superray
