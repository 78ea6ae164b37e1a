#include "scan_walk.h"

#include <superray/core/parallel.h>

#include "chunk_queue.h"

#include <algorithm>

namespace superray {
namespace {

/// Rays that repay a thread.
constexpr std::size_t kRaysPerShare = 256;

/// Chunks of beams per thread, at least about so many.
constexpr std::size_t kChunksPerShare = 16;

/// Adds `more` to `sum`, saturating.
template <int Dim>
void add(std::uint8_t* sum, const std::uint8_t* more) {
    for (int i = 0; i < kBlockCells<Dim>; ++i) {
        const auto s = static_cast<std::uint8_t>(sum[i] + more[i]);
        sum[i] = s < more[i] ? std::uint8_t{255} : s;
    }
}

/// What becomes of blocks that the sum has no counts of.
enum class NewBlocks { copied, borrowed };

/// Adds the counts of `from` to those of `to`.
template <int Dim>
void mergeInto(WalkState<Dim>& to, const WalkState<Dim>& from, NewBlocks newBlocks) {
    for (std::size_t b = 0; b < from.batch.blockCount(); ++b) {
        const BlockKey<Dim>& key = from.batch.key(b);
        const std::uint8_t* const hits = from.batch.hits(b);
        std::optional<std::uint32_t> own = to.ownBatchBlock(key);
        if (!own && newBlocks == NewBlocks::borrowed) {
            to.batch.borrowBlock(key, from.batch.misses(b), hits);
            continue;
        }
        if (!own) own = to.batchBlock(key);
        add<Dim>(to.batch.missesOf(*own), from.batch.misses(b));
        if (hits != nullptr) add<Dim>(to.batch.hitsOf(*own), hits);
    }
    to.traversed += from.traversed;
}

}  // namespace

template <int Dim>
void ScanWalk<Dim>::begin(const RayBundle<Dim>& rays, const ScanExtent<Dim>& extent,
                          unsigned threads) {
    rays_ = &rays;
    const BlockBox<Dim> blocks = extent.blocks();
    shareCount_ =
        std::max<std::size_t>(1, std::min<std::size_t>(threads, rays.size() / kRaysPerShare));
    if (shares_.size() < shareCount_) shares_.resize(shareCount_);
    inParallel(shareCount_, [&](std::size_t s) {
        Share& share = shares_[s];
        share.state.reset(blocks);
        share.culled = 0;
    });
}

template <int Dim>
void ScanWalk<Dim>::countEndCells() {
    inParallel(shareCount_, [&](std::size_t s) {
        Share& share = shares_[s];
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

template <int Dim>
void ScanWalk<Dim>::walkBeams(const SaturationSource<Dim>* map, const SensorModel& model,
                              UpdatePolicy policy) {
    static const FindEnds<Dim> findEnds = bestKernels<Dim>().findEnds;
    tree_.find(*rays_, shareCount_);
    findChunks();
    ends_.resize(rays_->size());
    inParallel(shareCount_, [&](std::size_t s) {
        const BlockDirectory<Dim>& directory = shares_[s].state.directory;
        if (directory.dense())
            findEnds(*rays_, firstRay(s, rays_->size()), firstRay(s + 1, rays_->size()),
                     directory, ends_);
    });
    ChunkQueue queue(chunks_.size(), shareCount_);
    inParallel(shareCount_, [&](std::size_t s) {
        Share& share = shares_[s];
        share.state.countMapSaturation(map, model, policy);
        share.beams.begin(*rays_, tree_, ends_, share.state);
        if (shareCount_ == 1) share.beams.addHits();
        while (const auto c = queue.take(s)) {
            if (shareCount_ > 1) share.beams.addHits(chunks_[*c]);
            share.beams.walk(chunks_[*c]);
        }
        share.beams.end();
        share.culled += share.beams.culled();
    });
}

/// Nodes of the tree that hold all rays together and, for several threads, are
/// small enough to be shared out.
template <int Dim>
void ScanWalk<Dim>::findChunks() {
    chunks_.clear();
    const std::size_t most = shareCount_ == 1
                                 ? tree_.runs().size()
                                 : tree_.runs().size() / (kChunksPerShare * shareCount_) + 1;
    std::vector<typename BeamTree<Dim>::Node> open;
    for (std::uint32_t kind = BeamTree<Dim>::kKinds; kind-- > 0;)
        open.push_back(tree_.root(kind));
    while (!open.empty()) {
        const auto node = open.back();
        open.pop_back();
        if (node.first == node.last) continue;
        if (node.last - node.first <= most || node.level == tree_.levels()) {
            chunks_.push_back(node);
            continue;
        }
        for (std::uint32_t i = BeamTree<Dim>::kChildren; i-- > 0;)
            open.push_back(tree_.child(node, i));
    }
}

template <int Dim>
const WalkState<Dim>& ScanWalk<Dim>::finish() {
    for (std::size_t s = 1; s < shareCount_; ++s)
        mergeInto(shares_[0].state, shares_[s].state,
                  s + 1 == shareCount_ ? NewBlocks::borrowed : NewBlocks::copied);
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
