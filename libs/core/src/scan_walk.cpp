#include "scan_walk.h"

#include <algorithm>
#include <exception>
#include <thread>

#include "ray_frustum.h"

namespace superray {
namespace {

/// Rays to one end cell that are walked between two looks at their frustum.
constexpr std::uint32_t kRaysPerLook = 8;

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
        const std::uint32_t block = to.blockNumber(from.batch.key(b));
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
    inParallel([&](std::size_t s, Share& share) {
        share.state.reset(blocks);
        share.ends.assign(rays, firstRay(s, rays.size()), firstRay(s + 1, rays.size()), blocks);
        share.culled = 0;
    });
}

template <int Dim>
std::size_t ScanWalk<Dim>::endCells() const {
    std::size_t n = 0;
    for (std::size_t s = 0; s < shareCount_; ++s) n += shares_[s].ends.distinct();
    return n;
}

template <int Dim>
void ScanWalk<Dim>::walkSuperRays(const std::vector<SuperRay>& superRays,
                                  const CullingRegion<Dim>& region) {
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
void ScanWalk<Dim>::walkDense(const SaturationSource<Dim>* map, float lowerClamp,
                              std::uint32_t enough) {
    const CullingRegion<Dim> noRegion;
    inParallel([&](std::size_t, Share& share) {
        share.state.countMapSaturation(map, lowerClamp);
        share.ends.sortByEndCell();
        const std::vector<std::uint32_t>& starts = share.ends.starts();
        const std::uint32_t* order = share.ends.order().data();
        RayWalker<Dim> walker(share.state, *rays_, noRegion);
        for (std::size_t g = 0; g + 1 < starts.size(); ++g)
            walkGroup(walker, share, order + starts[g], order + starts[g + 1], enough);
    });
}

/// Walks the rays [begin, end), all to one end cell.
template <int Dim>
void ScanWalk<Dim>::walkGroup(RayWalker<Dim>& walker, Share& share, const std::uint32_t* begin,
                              const std::uint32_t* end, std::uint32_t enough) const {
    std::vector<RayLine<Dim>>& lines = share.lines;
    lines.clear();
    const CellGeometry<Dim>& geometry = rays_->geometry();
    const Units<Dim> origin = RayLine<Dim>::unitsOf(geometry, rays_->commonOrigin());
    for (const std::uint32_t* ray = begin; ray != end; ++ray)
        lines.emplace_back(origin, RayLine<Dim>::unitsOf(geometry, rays_->end(*ray)));
    RayFrustum<Dim> frustum(lines.front());
    // Lines of another kind than the first are walked at once, in full.
    const auto alike =
        std::partition(lines.begin(), lines.end(),
                       [&](const RayLine<Dim>& line) { return frustum.include(line); });
    for (auto line = alike; line != lines.end(); ++line)
        walker.walk(*line, {0, line->slices()}, 1);
    lines.erase(alike, lines.end());

    // Evenly spread rays first: ray i, i + strides, i + 2 strides, ...
    const std::size_t strides = (lines.size() + kRaysPerLook - 1) / kRaysPerLook;
    walker.flush();
    SliceRange range = frustum.unsaturated(share.state, enough, {0, frustum.slices()});
    std::size_t walked = 0;
    for (std::size_t i = 0; i < strides && !range.empty(); ++i) {
        for (std::size_t r = i; r < lines.size(); r += strides, ++walked)
            walker.walk(lines[r], range, 1);
        walker.flush();
        range = frustum.unsaturated(share.state, enough, range);
    }
    share.culled += lines.size() - walked;
}

template <int Dim>
const WalkState<Dim>& ScanWalk<Dim>::finish() {
    for (std::size_t s = 0; s < shareCount_; ++s) {
        shares_[s].ends.addHits(shares_[s].state);
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
