// SPDX-License-Identifier: BSD-3-Clause
#include "scan_walk.h"

#include <superray/core/detail/parallel.h>

#include <algorithm>
#include <array>

namespace superray {
namespace {

/// Rays, blocks to add that repay a thread.
constexpr std::size_t kRaysPerChunk = 256, kBlocksPerChunk = 512;

/// Rays of so many cells repay sorting them by direction.
constexpr double kLongRay = 64;

/// A sample must spare the other rays at least a quarter of their slices.
constexpr double kRepays = 0.75;

/// Adds `more` to `sum`, saturating.
template <int Dim>
void add(std::uint8_t* sum, const std::uint8_t* more) {
    for (int i = 0; i < kBlockCells<Dim>; ++i) {
        const auto s = static_cast<std::uint8_t>(sum[i] + more[i]);
        sum[i] = s < more[i] ? std::uint8_t{255} : s;
    }
}

/// Ends a walk, also where it fails: others wait for that.
template <int Dim>
struct EndOfWalk {
    SkippingWalk<Dim>& walk;
    ~EndOfWalk() { walk.end(); }
};

/// What becomes of blocks that the sum has no counts of.
enum class NewBlocks { copied, borrowed };

/// Adds the counts of `from` to those of `to`, in up to `threads` threads.
template <int Dim>
void mergeInto(ScanCounts<Dim>& to, const ScanCounts<Dim>& from, NewBlocks newBlocks,
               std::size_t threads) {
    const std::size_t blocks = from.batch.blockCount();
    const std::size_t chunks = chunkCountFor(blocks, kBlocksPerChunk, threads);
    const auto addTo = [&](std::uint32_t own, std::size_t b) {
        add<Dim>(to.batch.missesOf(own), from.batch.misses(b));
        if (const std::uint8_t* const hits = from.batch.hits(b))
            add<Dim>(to.batch.hitsOf(own), hits);
    };
    std::vector<std::vector<std::size_t>> left(chunks);  // those that need memory
    inParallel(chunks, [&](std::size_t chunk) {
        const std::size_t end = chunkBegin(blocks, chunk + 1, chunks);
        for (std::size_t b = chunkBegin(blocks, chunk, chunks); b < end; ++b) {
            const auto own = to.ownBatchBlock(from.batch.key(b));
            if (own && (from.batch.hits(b) == nullptr || to.batch.hits(*own) != nullptr))
                addTo(*own, b);
            else
                left[chunk].push_back(b);
        }
    });
    for (const auto& some : left)
        for (const std::size_t b : some) {
            const BlockKey<Dim>& key = from.batch.key(b);
            if (newBlocks == NewBlocks::copied || to.ownBatchBlock(key))
                addTo(to.batchBlock(key), b);
            else
                to.batch.borrowBlock(key, from.batch.misses(b), from.batch.hits(b));
        }
    to.traversed += from.traversed;
}

}  // namespace

template <int Dim>
void ScanWalk<Dim>::begin(const RayBundle<Dim>& rays, const ScanBounds<Dim>& bounds,
                          unsigned threads) {
    rays_ = &rays;
    blocks_ = bounds.blocks();
    chunkCount_ = chunkCountFor(rays.size(), kRaysPerChunk, threads);
    if (workers_.size() < chunkCount_) workers_.resize(chunkCount_);
    for (Worker& worker : workers_) worker.culled = 0;
}

template <int Dim>
void ScanWalk<Dim>::countEndCells() {
    inParallel(chunkCount_, [&](std::size_t s) {
        Worker& worker = workers_[s];
        worker.counts.reset(blocks_);
        worker.ends.assign(*rays_, firstRay(s, rays_->size()), firstRay(s + 1, rays_->size()),
                           worker.counts.directory.box());
        worker.ends.addHits(worker.counts);
    });
}

template <int Dim>
void ScanWalk<Dim>::walkSuperRays(const std::vector<SuperRay>& superRays,
                                  const CullingRegion<Dim>& region) {
    countEndCells();
    inParallel(chunkCount_, [&](std::size_t s) {
        Worker& worker = workers_[s];
        RayWalker<Dim> walker(worker.counts, *rays_, region);
        const std::size_t end = firstRay(s + 1, superRays.size());
        for (std::size_t i = firstRay(s, superRays.size()); i < end; ++i)
            walker.walk(superRays[i].ray, superRays[i].weight);
        worker.culled += walker.culled();
    });
}

template <int Dim>
void ScanWalk<Dim>::walkEach(const CullingRegion<Dim>& region) {
    countEndCells();
    const bool culling = !region.empty() && rays_->hasCommonOrigin();
    inParallel(chunkCount_, [&](std::size_t s) {
        Worker& worker = workers_[s];
        if (culling) worker.ends.findEnclosed(region);
        RayWalker<Dim> walker(worker.counts, *rays_, region);
        const std::size_t end = firstRay(s + 1, rays_->size());
        for (std::size_t i = firstRay(s, rays_->size()); i < end; ++i) {
            if (culling && worker.ends.enclosed(i))
                ++worker.culled;
            else
                walker.walk(i, 1);
        }
        worker.culled += walker.culled();
    });
}

/// Whether several threads should take rays by direction.
template <int Dim>
bool ScanWalk<Dim>::sortingRepays() const {
    return chunkCount_ > 1 && goAllAround(*rays_) &&
           typicalLength(*rays_, 0, rays_->size()) > kLongRay;
}

template <int Dim>
void ScanWalk<Dim>::learn() {
    SampleEffect sum;
    std::vector<double> work;
    for (std::size_t s = 0; s < chunkCount_; ++s) {
        sum.before += workers_[s].walk.sampleEffect().before;
        sum.after += workers_[s].walk.sampleEffect().after;
        work.push_back(workers_[s].walk.work());
    }
    balance_.learn(work);
    if (sum.before > 0) sampleRepays_.learn(sum.after < kRepays * sum.before);
}

template <int Dim>
void ScanWalk<Dim>::walkSkipping(const SaturationSource<Dim>* map, const SensorModel& model,
                                 UpdatePolicy policy) {
    const Sampling sampling =
        sampleRepays_.tryNow() ? Sampling::whereItMayRepay : Sampling::never;
    const bool sorting = sortingRepays();
    if (sorting) sortByDirection();
    balance_.begin(chunkCount_);
    const SkippingScan<Dim> scan{sorting ? *sorted_ : *rays_, map, {model, policy}, sampling};
    inParallel(chunkCount_, [&](std::size_t s) {
        Worker& worker = workers_[s];
        SkippingWalk<Dim>& walk = worker.walk;
        {
            const EndOfWalk<Dim> atEnd{walk};
            if (!sorting) worker.counts.reset(blocks_);
            walk.begin(scan, worker.counts);
            walk.walk(balance_.first(rays_->size(), s), balance_.first(rays_->size(), s + 1));
        }
        for (std::size_t i = 1; i < chunkCount_; ++i)
            walk.help(workers_[(s + i) % chunkCount_].walk);
        worker.culled += walk.culled();
    });
    learn();
}

/// Orders the rays by sector, so that threads take rays that go different ways, and few
/// blocks are counted by several. Those of a sector stay in the sensor's order.
template <int Dim>
void ScanWalk<Dim>::sortByDirection() {
    const std::size_t count = rays_->size();
    inParallel(chunkCount_, [&](std::size_t s) {
        workers_[s].counts.reset(blocks_);
        findSectors(workers_[s], firstRay(s, count), firstRay(s + 1, count));
    });
    std::size_t begin = 0;
    for (std::size_t sector = 0; sector < kSortedSectors; ++sector) {
        for (std::size_t s = 0; s < chunkCount_; ++s) {
            // From counts to where the share's rays of the sector go.
            const std::size_t n = workers_[s].ofSector[sector];
            workers_[s].ofSector[sector] = begin;
            begin += n;
        }
    }
    if (!sorted_) sorted_.emplace(rays_->geometry(), rays_->commonOrigin());
    sorted_->restartLike(*rays_);
    inParallel(chunkCount_, [&](std::size_t s) {
        std::size_t ray = firstRay(s, count);
        for (const std::uint8_t sector : workers_[s].sectors)
            sorted_->place(workers_[s].ofSector[sector]++, *rays_, ray++);
    });
}

/// Finds the sectors of the rays [first, last), and how many there are of each.
template <int Dim>
void ScanWalk<Dim>::findSectors(Worker& worker, std::size_t first, std::size_t last) {
    static const ClassifyRays<Dim> classifyRays = bestKernels<Dim>().classifyRays;
    constexpr std::size_t kMost = ClassifiedBatch<Dim>::kMost;
    DirectionBins<Dim> bins;
    ClassifiedBatch<Dim> directions;
    std::array<std::uint32_t, kMost> subBin;
    std::array<std::uint16_t, kMost> lastSlice;
    worker.sectors.resize(last - first);
    worker.ofSector.fill(0);
    for (std::size_t at = first; at < last; at += kMost) {
        const std::size_t n = std::min(kMost, last - at);
        classifyRays(*rays_, at, n, worker.counts.directory, bins, subBin.data(),
                     lastSlice.data(), directions);
        for (std::size_t i = 0; i < n; ++i) {
            const std::uint32_t sector = bins.sectorOf(subBin[i]);
            worker.sectors[at - first + i] = static_cast<std::uint8_t>(sector);
            ++worker.ofSector[sector];
        }
    }
}

template <int Dim>
const ScanCounts<Dim>& ScanWalk<Dim>::finish() {
    for (std::size_t s = 1; s < chunkCount_; ++s)
        mergeInto(workers_[0].counts, workers_[s].counts,
                  s + 1 == chunkCount_ ? NewBlocks::borrowed : NewBlocks::copied, chunkCount_);
    return workers_[0].counts;
}

template <int Dim>
void ScanWalk<Dim>::reserve(std::size_t bytes, unsigned threads) {
    if (workers_.size() < threads) workers_.resize(threads);
    for (std::size_t s = 0; s < threads; ++s) workers_[s].counts.batch.reserve(bytes / threads);
}

template <int Dim>
std::uint64_t ScanWalk<Dim>::culled() const {
    std::uint64_t n = 0;
    for (std::size_t s = 0; s < chunkCount_; ++s) n += workers_[s].culled;
    return n;
}

template class ScanWalk<2>;
template class ScanWalk<3>;

}  // namespace superray
