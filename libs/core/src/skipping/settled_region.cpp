// SPDX-License-Identifier: BSD-3-Clause
#include "skipping/settled_region.h"

#include "skipping/mask_fill.h"

namespace superray {

template <int Dim>
void SettledRegion<Dim>::reset(const BlockBox<Dim>& box, const SaturationSource<Dim>* map,
                               const SaturationLimits& limits) {
    map_ = map;
    limits_ = limits;
    directory_.reset(box);
    blocks_.clear();
    build_ = 0;
}

template <int Dim>
void SettledRegion<Dim>::build(const Cell<Dim>& sensor, const ScanCounts<Dim>& counts,
                               DirectionRanges<Dim>& ranges, std::uint64_t mostWork) {
    counts_ = &counts;
    ranges_ = &ranges;
    ++build_;
    work_ = 0;
    mostWork_ = mostWork;
    queue_.clear();
    visited_.clear();
    ranges.clear();
    const std::uint32_t first = blockAt(blockOf<Dim>(sensor));
    enter(blocks_[first]);
    const int at = indexInBlock<Dim>(sensor);
    if (!blocks_[first].settled.test(at)) {
        ranges.markAll();
        return;
    }
    blocks_[first].reached.set(at);
    queue_.push_back(first);
    for (std::size_t i = 0; i < queue_.size(); ++i) spread(queue_[i]);
    for (const std::uint32_t id : visited_) mark(blocks_[id]);
    ranges.completeUnsettled();
}

/// Number of a block, which is made on first use.
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

/// Prepares a block that this build has not come to before.
/// \return false if no ray gets there
template <int Dim>
bool SettledRegion<Dim>::enter(Block& block) {
    if (block.build == build_) return block.relevant;
    block.relevant = ranges_->sees(block.key);
    block.build = build_;
    block.queued = false;
    block.reached = block.boundary = block.marked = {};
    if (!block.relevant) return false;
    findSettled(block);
    visited_.push_back(static_cast<std::uint32_t>(&block - blocks_.data()));
    work_ += 40;
    return true;
}

template <int Dim>
void SettledRegion<Dim>::findSettled(Block& block) {
    static const AtLeast<Dim> atLeast = bestKernels<Dim>().atLeast;
    if (!block.knowsMap && map_ != nullptr)
        block.inMap = map_->saturation(block.key, limits_.lowerClamp);
    block.knowsMap = true;
    block.settled = block.inMap.saturatedFree;
    const auto counted = counts_->ownBatchBlock(block.key);
    if (!counted || block.settled.all()) return;
    const BlockMask<Dim> missed =
        atLeast(counts_->batch.misses(*counted),
                block.inMap.mayExceedUnknown ? limits_.misses : limits_.missesOfUnknown);
    for (int w = 0; w < BlockMask<Dim>::kWords; ++w) block.settled.words[w] |= missed.words[w];
}

/// Spreads the region in a block and to its neighbours.
template <int Dim>
void SettledRegion<Dim>::spread(std::uint32_t id) {
    blocks_[id].queued = false;
    {
        Block& block = blocks_[id];
        fill<Dim>(block.reached, block.settled);
        work_ += 40;
        mark(block);
    }
    // pass() may make blocks, which moves them all.
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

/// The region has come to these cells of a block.
template <int Dim>
void SettledRegion<Dim>::pass(const BlockKey<Dim>& to, const BlockMask<Dim>& cells) {
    const std::uint32_t id = blockAt(to);
    Block& block = blocks_[id];
    if (work_ > mostWork_ && block.build != build_) {
        // Whatever is settled there, the region ends here.
        if (ranges_->sees(to)) ranges_->markBoundary(to, cells);
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

/// Notes the boundary cells of a block that are not noted yet.
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
    ranges_->markBoundary(block.key, fresh);
    work_ += 8 * static_cast<std::uint64_t>(fresh.count()) + 100;
}

template class SettledRegion<2>;
template class SettledRegion<3>;

}  // namespace superray
