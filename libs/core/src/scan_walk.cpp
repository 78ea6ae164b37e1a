#include "scan_walk.h"

#include <algorithm>
#include <exception>
#include <thread>

namespace superray {
namespace {

/// Rays that repay a thread.
constexpr std::size_t kRaysPerShare = 256;

/// Adds the counts of `from` to `to`.
template <int Dim>
void mergeInto(WalkState<Dim>& to, const WalkState<Dim>& from) {
    const auto add = [](std::uint8_t* sum, const std::uint8_t* more) {
        for (int i = 0; i < kBlockCells<Dim>; ++i) {
            const unsigned s = unsigned{sum[i]} + more[i];
            sum[i] = static_cast<std::uint8_t>(s > 255 ? 255 : s);
        }
    };
    for (std::size_t b = 0; b < from.batch.blockCount(); ++b) {
        const std::uint32_t block = to.batchBlock(from.batch.key(b));
        add(to.batch.missesOf(block), from.batch.misses(b));
        if (from.batch.hits(b) != nullptr) add(to.batch.hitsOf(block), from.batch.hits(b));
    }
    to.traversed += from.traversed;
}

}  // namespace

/// Runs work(share) for each share, the first in this thread.
template <int Dim>
template <typename Work>
void ScanWalk<Dim>::inParallel(const Work& work) {
    std::vector<std::exception_ptr> failures(shareCount_);
    const auto guarded = [&](std::size_t s) {
        try {
            work(s, shares_[s]);
        } catch (...) {
            failures[s] = std::current_exception();
        }
    };
    std::vector<std::thread> threads;
    for (std::size_t s = 1; s < shareCount_; ++s) threads.emplace_back(guarded, s);
    guarded(0);
    for (std::thread& t : threads) t.join();
    for (const std::exception_ptr& failure : failures)
        if (failure) std::rethrow_exception(failure);
}

template <int Dim>
void ScanWalk<Dim>::begin(const RayBundle<Dim>& rays, const ScanExtent<Dim>& extent,
                          unsigned threads) {
    rays_ = &rays;
    const BlockBox<Dim> blocks = extent.blocks();
    shareCount_ =
        std::max<std::size_t>(1, std::min<std::size_t>(threads, rays.size() / kRaysPerShare));
    if (shares_.size() < shareCount_) shares_.resize(shareCount_);
    inParallel([&](std::size_t, Share& share) {
        share.state.reset(blocks);
        share.culled = 0;
    });
}

template <int Dim>
void ScanWalk<Dim>::countEndCells() {
    inParallel([&](std::size_t s, Share& share) {
        share.ends.assign(*rays_, firstRay(s, rays_->size()), firstRay(s + 1, rays_->size()),
                          share.state.directory.box());
        share.ends.addHits(share.state);
    });
}

template <int Dim>
void ScanWalk<Dim>::walkSuperRays(const std::vector<SuperRay>& superRays,
                                  const CullingRegion<Dim>& region) {
    countEndCells();
    inParallel([&](std::size_t s, Share& share) {
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
    inParallel([&](std::size_t s, Share& share) {
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

template <int Dim>
void ScanWalk<Dim>::walkBeams(const SaturationSource<Dim>* map, const SensorModel& model,
                              UpdatePolicy policy) {
    finder_.find(*rays_);
    inParallel([&](std::size_t s, Share& share) {
        share.state.countMapSaturation(map, model, policy);
        const std::size_t beams = finder_.beams().size();
        share.beams.walk(*rays_, finder_, firstRay(s, beams), firstRay(s + 1, beams),
                         share.state);
        share.culled += share.beams.culled();
    });
}

template <int Dim>
const WalkState<Dim>& ScanWalk<Dim>::finish() {
    for (std::size_t s = 0; s < shareCount_; ++s) {
        if (s > 0) mergeInto(shares_[0].state, shares_[s].state);
    }
    return shares_[0].state;
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
