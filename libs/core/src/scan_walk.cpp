#include "scan_walk.h"

#include <superray/core/parallel.h>

#include <algorithm>
#include <array>

namespace superray {
namespace {

/// Rays, blocks to add that repay a thread.
constexpr std::size_t kRaysPerShare = 256, kBlocksPerShare = 512;

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
    HorizonWalk<Dim>& walk;
    ~EndOfWalk() { walk.end(); }
};

/// What becomes of blocks that the sum has no counts of.
enum class NewBlocks { copied, borrowed };

/// Adds the counts of `from` to those of `to`, in up to `threads` threads.
template <int Dim>
void mergeInto(WalkState<Dim>& to, const WalkState<Dim>& from, NewBlocks newBlocks,
               std::size_t threads) {
    const std::size_t blocks = from.batch.blockCount();
    const std::size_t shares = shareCountFor(blocks, kBlocksPerShare, threads);
    const auto addTo = [&](std::uint32_t own, std::size_t b) {
        add<Dim>(to.batch.missesOf(own), from.batch.misses(b));
        if (const std::uint8_t* const hits = from.batch.hits(b))
            add<Dim>(to.batch.hitsOf(own), hits);
    };
    std::vector<std::vector<std::size_t>> left(shares);  // those that need memory
    inParallel(shares, [&](std::size_t share) {
        const std::size_t end = shareBegin(blocks, share + 1, shares);
        for (std::size_t b = shareBegin(blocks, share, shares); b < end; ++b) {
            const auto own = to.ownBatchBlock(from.batch.key(b));
            if (own && (from.batch.hits(b) == nullptr || to.batch.hits(*own) != nullptr))
                addTo(*own, b);
            else
                left[share].push_back(b);
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
void ScanWalk<Dim>::begin(const RayBundle<Dim>& rays, const ScanExtent<Dim>& extent,
                          unsigned threads) {
    rays_ = &rays;
    blocks_ = extent.blocks();
    shareCount_ = shareCountFor(rays.size(), kRaysPerShare, threads);
    if (shares_.size() < shareCount_) shares_.resize(shareCount_);
    for (Share& share : shares_) share.culled = 0;
}

template <int Dim>
void ScanWalk<Dim>::countEndCells() {
    inParallel(shareCount_, [&](std::size_t s) {
        Share& share = shares_[s];
        share.state.reset(blocks_);
        share.ends.assign(*rays_, firstRay(s, rays_->size()), firstRay(s + 1, rays_->size()),
                          share.state.directory.box());
        share.ends.addHits(share.state);
    });
}

template <int Dim>
void ScanWalk<Dim>::walkSuperRays(const std::vector<SuperRay>& superRays,
                                  const CullingRegion<Dim>& region) {
    countEndCells();
    inParallel(shareCount_, [&](std::size_t s) {
        Share& share = shares_[s];
        RayWalker<Dim> walker(share.state, *rays_, region);
        const std::size_t end = firstRay(s + 1, superRays.size());
        for (std::size_t i = firstRay(s, superRays.size()); i < end; ++i)
            walker.walk(superRays[i].ray, superRays[i].weight);
        share.culled += walker.culled();
    });
}

template <int Dim>
void ScanWalk<Dim>::walkEach(const CullingRegion<Dim>& region) {
    countEndCells();
    const bool culling = !region.empty() && rays_->hasCommonOrigin();
    inParallel(shareCount_, [&](std::size_t s) {
        Share& share = shares_[s];
        if (culling) share.ends.findEnclosed(region);
        RayWalker<Dim> walker(share.state, *rays_, region);
        const std::size_t end = firstRay(s + 1, rays_->size());
        for (std::size_t i = firstRay(s, rays_->size()); i < end; ++i) {
            if (culling && share.ends.enclosed(i))
                ++share.culled;
            else
                walker.walk(i, 1);
        }
        share.culled += walker.culled();
    });
}

/// Whether several threads should take rays by direction.
template <int Dim>
bool ScanWalk<Dim>::sortingRepays() const {
    return shareCount_ > 1 && goAllAround(*rays_) &&
           typicalLength(*rays_, 0, rays_->size()) > kLongRay;
}

template <int Dim>
void ScanWalk<Dim>::learn() {
    SampleEffect sum;
    std::vector<double> work;
    for (std::size_t s = 0; s < shareCount_; ++s) {
        sum.before += shares_[s].horizon.sampleEffect().before;
        sum.after += shares_[s].horizon.sampleEffect().after;
        work.push_back(shares_[s].horizon.work());
    }
    balance_.learn(work);
    if (sum.before > 0) sampleRepays_.learn(sum.after < kRepays * sum.before);
}

template <int Dim>
void ScanWalk<Dim>::walkFromHorizon(const SaturationSource<Dim>* map, const SensorModel& model,
                                    UpdatePolicy policy) {
    const Sampling sampling =
        sampleRepays_.tryNow() ? Sampling::whereItMayRepay : Sampling::never;
    const bool sorting = sortingRepays();
    if (sorting) sortByDirection();
    balance_.begin(shareCount_);
    const HorizonScan<Dim> scan{sorting ? *sorted_ : *rays_, map, {model, policy}, sampling};
    inParallel(shareCount_, [&](std::size_t s) {
        Share& share = shares_[s];
        HorizonWalk<Dim>& walk = share.horizon;
        {
            const EndOfWalk<Dim> atEnd{walk};
            if (!sorting) share.state.reset(blocks_);
            walk.begin(scan, share.state);
            walk.walk(balance_.first(rays_->size(), s), balance_.first(rays_->size(), s + 1));
        }
        for (std::size_t i = 1; i < shareCount_; ++i)
            walk.help(shares_[(s + i) % shareCount_].horizon);
        share.culled += walk.culled();
    });
    learn();
}

/// Orders the rays by kind, so that threads take rays that go different ways, and few
/// blocks are counted by several. Those of a kind stay in the sensor's order.
template <int Dim>
void ScanWalk<Dim>::sortByDirection() {
    const std::size_t count = rays_->size();
    inParallel(shareCount_, [&](std::size_t s) {
        shares_[s].state.reset(blocks_);
        findKinds(shares_[s], firstRay(s, count), firstRay(s + 1, count));
    });
    std::size_t begin = 0;
    for (std::size_t kind = 0; kind < kSortedKinds; ++kind) {
        for (std::size_t s = 0; s < shareCount_; ++s) {
            // From counts to where the share's rays of the kind go.
            const std::size_t n = shares_[s].ofKind[kind];
            shares_[s].ofKind[kind] = begin;
            begin += n;
        }
    }
    if (!sorted_) sorted_.emplace(rays_->geometry(), rays_->commonOrigin());
    sorted_->restartLike(*rays_);
    inParallel(shareCount_, [&](std::size_t s) {
        std::size_t ray = firstRay(s, count);
        for (const std::uint8_t kind : shares_[s].kinds)
            sorted_->place(shares_[s].ofKind[kind]++, *rays_, ray++);
    });
}

/// Finds the kinds of the rays [first, last), and how many there are of each.
template <int Dim>
void ScanWalk<Dim>::findKinds(Share& share, std::size_t first, std::size_t last) {
    static const FindDirections<Dim> findDirections = bestKernels<Dim>().findDirections;
    constexpr std::size_t kMost = RayDirections<Dim>::kMost;
    DirectionTiles<Dim> tiles;
    RayDirections<Dim> directions;
    std::array<std::uint32_t, kMost> spot;
    std::array<std::uint16_t, kMost> lastSlice;
    share.kinds.resize(last - first);
    share.ofKind.fill(0);
    for (std::size_t at = first; at < last; at += kMost) {
        const std::size_t n = std::min(kMost, last - at);
        findDirections(*rays_, at, n, share.state.directory, tiles, spot.data(),
                       lastSlice.data(), directions);
        for (std::size_t i = 0; i < n; ++i) {
            const std::uint32_t kind = tiles.kindOf(spot[i]);
            share.kinds[at - first + i] = static_cast<std::uint8_t>(kind);
            ++share.ofKind[kind];
        }
    }
}

template <int Dim>
const WalkState<Dim>& ScanWalk<Dim>::finish() {
    for (std::size_t s = 1; s < shareCount_; ++s)
        mergeInto(shares_[0].state, shares_[s].state,
                  s + 1 == shareCount_ ? NewBlocks::borrowed : NewBlocks::copied, shareCount_);
    return shares_[0].state;
}

template <int Dim>
void ScanWalk<Dim>::reserve(std::size_t bytes, unsigned threads) {
    if (shares_.size() < threads) shares_.resize(threads);
    for (std::size_t s = 0; s < threads; ++s) shares_[s].state.batch.reserve(bytes / threads);
}

template <int Dim>
std::uint64_t ScanWalk<Dim>::culled() const {
    std::uint64_t n = 0;
    for (std::size_t s = 0; s < shareCount_; ++s) n += shares_[s].culled;
    return n;
}

template class ScanWalk<2>;
template class ScanWalk<3>;

}  // namespace superray
