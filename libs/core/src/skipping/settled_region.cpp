// SPDX-License-Identifier: BSD-3-Clause
#include "skipping/settled_region.h"

#include "kernels/walk_kernel.h"
#include "skipping/mask_fill.h"
#include "tuning.h"

namespace superray {

template <int Dim>
void SettledRegion<Dim>::reset(const BlockBox<Dim>& box, const SaturationSource<Dim>* map,
                               const SaturationLimits& limits, const ScanHits<Dim>* hitsOfAll) {
    map_ = map;
    hitsOfAll_ = hitsOfAll;
    limits_ = limits;
    directory_.reset(box);
    blocks_.clear();
    growth_ = 0;
}

template <int Dim>
Boundary SettledRegion<Dim>::grow(const Cell<Dim>& sensor, const ScanCounts<Dim>& counts,
                                  DirectionRanges<Dim>& ranges, std::uint64_t mostWork) {
    Marker marker(ranges);
    marker_ = &marker;
    counts_ = &counts;
    ++growth_;
    work_ = 0;
    mostWork_ = mostWork;
    queue_.clear();
    visited_.clear();
    const std::uint32_t home = blockAt(blockOf<Dim>(sensor));
    enter(blocks_[home]);
    const int at = indexInBlock<Dim>(sensor);
    if (!blocks_[home].settled.test(at)) {
        marker.markAll();
        return {false, work_};
    }
    blocks_[home].reached.set(at);
    queue_.push_back(home);
    for (std::size_t i = 0; i < queue_.size(); ++i) spread(queue_[i]);
    for (const std::uint32_t id : visited_) mark(blocks_[id]);
    return {true, work_};
}

/// Id of a block, which is made on first use.
template <int Dim>
std::uint32_t SettledRegion<Dim>::blockAt(const BlockKey<Dim>& key) {
    std::uint32_t id = directory_.id(key);
    if (id == 0) {
        blocks_.emplace_back();
        blocks_.back().key = key;
        id = static_cast<std::uint32_t>(blocks_.size());
        directory_.setId(key, id);
    }
    return id - 1;
}

/// Prepares a block that this growth has not come to before.
/// \return false if no ray gets there
template <int Dim>
bool SettledRegion<Dim>::enter(Block& block) {
    if (block.growth == growth_) return block.relevant;
    block.relevant = marker_->ranges().sees(block.key);
    block.growth = growth_;
    block.queued = false;
    block.reached = block.boundary = block.marked = {};
    if (!block.relevant) return false;
    findSettled(block);
    visited_.push_back(static_cast<std::uint32_t>(&block - blocks_.data()));
    work_ += SkippingCosts::kVisitBlock;
    return true;
}

/// Finds the settled cells of a block. The map is asked once per scan.
template <int Dim>
void SettledRegion<Dim>::findSettled(Block& block) {
    static const AtLeast<Dim> atLeast = bestKernels<Dim>().atLeast;
    if (!block.knowsMap && map_ != nullptr)
        block.inMap = map_->saturation(block.key, limits_.lowerClamp);
    block.knowsMap = true;
    block.settled = block.inMap.saturatedFree;
    const auto counted = counts_->ownBatchBlock(block.key);
    const std::uint8_t* const misses = counted ? counts_->batch.misses(*counted) : nullptr;
    if (misses != nullptr && !block.settled.all()) {
        const BlockMask<Dim> missed = atLeast(
            misses, block.inMap.mayExceedUnknown ? limits_.misses : limits_.missesOfUnknown);
        for (int w = 0; w < BlockMask<Dim>::kWords; ++w)
            block.settled.words[w] |= missed.words[w];
    }
    if (!limits_.hitsUnsettle) return;
    typename ScanHits<Dim>::Counts sum;
    const std::uint8_t* const hits = hitsOfAll_ != nullptr ? hitsOfAll_->hits(block.key, sum)
                                     : counted             ? counts_->batch.hits(*counted)
                                                           : nullptr;
    if (hits != nullptr) unsettleHits(block, misses, hits);
}

/// Decides anew about the cells of a block that are hit: how many misses settle them depends
/// on their hits.
/// \param misses nullptr: none
template <int Dim>
void SettledRegion<Dim>::unsettleHits(Block& block, const std::uint8_t* misses,
                                      const std::uint8_t* hits) const {
    static const AtLeast<Dim> atLeast = bestKernels<Dim>().atLeast;
    const BlockMask<Dim> hit = atLeast(hits, 1);
    for (int w = 0; w < BlockMask<Dim>::kWords; ++w) {
        std::uint64_t settled = 0;
        for (std::uint64_t left = hit.words[w]; left != 0; left &= left - 1) {
            const int bit = __builtin_ctzll(left), i = 64 * w + bit;
            const bool enough =
                (misses != nullptr ? misses[i] : 0) >= limits_.missesBesideHits[hits[i]];
            settled |= std::uint64_t{enough} << bit;
        }
        block.settled.words[w] = (block.settled.words[w] & ~hit.words[w]) | settled;
    }
}

/// Spreads the region inside a block, and to its neighbours.
template <int Dim>
void SettledRegion<Dim>::spread(std::uint32_t id) {
    blocks_[id].queued = false;
    {
        Block& block = blocks_[id];
        fill<Dim>(block.reached, block.settled);
        work_ += SkippingCosts::kSpreadInBlock;
        mark(block);
    }
    // Copies: pass() may make blocks, which moves all of them.
    const BlockMask<Dim> reached = blocks_[id].reached;
    const BlockKey<Dim> key = blocks_[id].key;
    for (int a = 0; a < Dim; ++a) {
        for (const int step : {-1, 1}) {
            BlockKey<Dim> to = key;
            to[a] += step;
            const BlockMask<Dim> cells = acrossFace<Dim>(reached, a, step);
            if (cells.any() && directory_.box().contains(to)) pass(to, cells);
        }
    }
}

/// Continues the region in a neighbouring block.
/// \param cells of that block, beside cells of the region
template <int Dim>
void SettledRegion<Dim>::pass(const BlockKey<Dim>& to, const BlockMask<Dim>& cells) {
    const std::uint32_t id = blockAt(to);
    Block& block = blocks_[id];
    if (work_ > mostWork_ && block.growth != growth_) {
        // The region ends here, whether these cells are settled or not.
        if (marker_->ranges().sees(to)) marker_->mark(to, cells);
        return;
    }
    if (!enter(block)) return;
    std::uint64_t fresh = 0;
    for (int w = 0; w < BlockMask<Dim>::kWords; ++w) {
        block.boundary.words[w] |= cells.words[w] & ~block.settled.words[w];
        const std::uint64_t more = cells.words[w] & block.settled.words[w];
        fresh |= more & ~block.reached.words[w];
        block.reached.words[w] |= more;
    }
    if (fresh == 0 || block.queued) return;
    block.queued = true;
    queue_.push_back(id);
}

/// Marks the boundary cells of a block that are not marked yet.
template <int Dim>
void SettledRegion<Dim>::mark(Block& block) {
    const BlockMask<Dim> beside = dilated<Dim>(block.reached);
    BlockMask<Dim> fresh;
    for (int w = 0; w < BlockMask<Dim>::kWords; ++w) {
        fresh.words[w] =
            (block.boundary.words[w] | (beside.words[w] & ~block.settled.words[w])) &
            ~block.marked.words[w];
        block.marked.words[w] |= fresh.words[w];
    }
    if (!fresh.any()) return;
    marker_->mark(block.key, fresh);
    work_ += SkippingCosts::kMarkCell * static_cast<std::uint64_t>(fresh.count()) +
             SkippingCosts::kMarkBlock;
}

template class SettledRegion<2>;
template class SettledRegion<3>;

}  // namespace superray
