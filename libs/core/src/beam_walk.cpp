#include "beam_walk.h"

#include <algorithm>
#include <iterator>

namespace superray {
namespace {

/// Starting the walk of a ray costs about as much as so many slices of it.
constexpr float kStart = 8;

/// "Nothing": no slice of a beam has anything to tell.
constexpr std::int32_t kNothing = -1;

}  // namespace

/// Up to 8 rays of neighbouring runs, and their bounds.
template <int Dim>
struct BeamWalk<Dim>::Leaf {
    RayLanes lanes;
    DirectionBounds<Dim> bounds;

    bool takes(const RayRun<Dim>& run) const {
        return lanes.count + run.count <= static_cast<int>(kGroupRays);
    }
    void add(const RayRun<Dim>& run) {
        if (lanes.count == 0)
            bounds = run;
        else
            bounds.include(run);
        for (std::uint32_t i = 0; i < run.count; ++i) lanes.ray[lanes.count++] = run.first + i;
    }
};

template <int Dim>
void BeamWalk<Dim>::begin(const RayBundle<Dim>& rays, const BeamTree<Dim>& tree,
                          const EndAddresses<Dim>& ends, WalkState<Dim>& state) {
    static const WalkKernels<Dim> best = bestKernels<Dim>(), portable = portableKernels<Dim>();
    kernels_ = state.directory.dense() ? best : portable;
    rays_ = &rays;
    tree_ = &tree;
    ends_ = &ends;
    state_ = &state;
    culled_ = 0;
    origin_ = RayLine<Dim>::unitsOf(rays.geometry(), rays.commonOrigin());
}

template <int Dim>
void BeamWalk<Dim>::walk(const Node& node) {
    if (node.first == node.last) return;
    if (node.kind == RayDirections<Dim>::kLone) {
        for (std::uint32_t i = node.first; i < node.last; ++i) walkLone(tree_->runs()[i]);
        return;
    }
    start_ = BeamStart<Dim>(node.kind, origin_);
    walkBelow(node, 0);
}

/// \param slice before this one, no cell of the node's rays matters
template <int Dim>
void BeamWalk<Dim>::walkBelow(const Node& node, std::int32_t slice) {
    const std::uint64_t rays = raysOf(node.first, node.last, 1);
    if (node.level == tree_->levels() || rays <= kGroupRays) {
        walkRuns(node, rays, slice);
        return;
    }
    Node children[BeamTree<Dim>::kChildren];
    std::uint32_t used = 0;
    for (std::uint32_t i = 0; i < BeamTree<Dim>::kChildren; ++i) {
        const Node child = tree_->child(node, i);
        if (child.first != child.last) children[used++] = child;
    }
    if (used == 1) {
        walkBelow(children[0], slice);
        return;
    }
    const DirectionBounds<Dim> bounds = tree_->bounds(node);
    Look look{slice};
    for (std::uint32_t i = 0; i < used; ++i) {
        // Again before each child: its siblings have saturated cells, too.
        lookAhead(bounds, look);
        if (look.slice == kNothing) {
            for (; i < used; ++i) culled_ += raysOf(children[i].first, children[i].last, 1);
            return;
        }
        walkBelow(children[i], look.slice);
    }
}

/// Walks the runs of a node, evenly spread ones first: these saturate the most.
/// \param rays how many there are
template <int Dim>
void BeamWalk<Dim>::walkRuns(const Node& node, std::uint64_t rays, std::int32_t slice) {
    // Every 8th run, those half-way between them, and so on; fewer passes if
    // these would have less rays than can be walked at once.
    std::uint32_t step = 8, first = 0;
    while (step > 1 && rays < step * kGroupRays) step /= 2;
    DirectionBounds<Dim> bounds;
    if (step > 1) bounds = tree_->bounds(node);
    Look look{slice};
    for (;;) {
        if (step > 1) lookAhead(bounds, look);
        Leaf leaf;
        leaf.lanes.kind = node.kind;
        for (std::uint32_t i = node.first + first; i < node.last; i += step) {
            const RayRun<Dim>& run = tree_->runs()[i];
            if (look.slice == kNothing) {
                culled_ += run.count;
                continue;
            }
            if (!leaf.takes(run)) {
                walkLeaf(leaf, look.slice);
                leaf.lanes.count = 0;
            }
            leaf.add(run);
        }
        if (leaf.lanes.count != 0) walkLeaf(leaf, look.slice);
        if (step == 1 || (step == 2 && first == 1)) return;
        if (first != 0) step /= 2;
        first = step / 2;
    }
}

template <int Dim>
std::uint64_t BeamWalk<Dim>::raysOf(std::uint32_t first, std::uint32_t last,
                                    std::uint32_t step) const {
    std::uint64_t rays = 0;
    for (; first < last; first += step) rays += tree_->runs()[first].count;
    return rays;
}

/// Looks on from where the last look has ended; the first slice that has
/// something to tell, or kNothing.
template <int Dim>
void BeamWalk<Dim>::lookAhead(const DirectionBounds<Dim>& rays, Look& look) {
    state_->flush(1);
    if (look.cell != Look::kNoCell && state_->batch.missArena()[look.cell] < look.needed)
        return;  // it still matters
    const Beam<Dim> beam(rays, start_);
    if (look.slice < beam.slices)
        look = kernels_.firstUnsaturated(*state_, beam, look.slice, beam.slices);
    if (look.slice >= beam.slices) look.slice = kNothing;
}

template <int Dim>
void BeamWalk<Dim>::walkLeaf(Leaf& leaf, std::int32_t from) {
    RayLanes& lanes = leaf.lanes;
    Look look{from};
    if (worthALook_.now()) {
        lookAhead(leaf.bounds, look);
        const float passed = look.slice == kNothing
                                 ? leaf.bounds.length + kStart
                                 : static_cast<float>(look.slice);
        worthALook_.learn((passed - static_cast<float>(from)) *
                          static_cast<float>(lanes.count));
    }
    const std::int32_t slice = look.slice;
    if (slice != 0) culled_ += static_cast<std::uint64_t>(lanes.count);
    if (slice == kNothing) return;
    // Rays that end before that slice have nothing to tell.
    const float shortest = 0.99999f * static_cast<float>(slice - 1);
    int left = 0;
    for (int i = 0; i < lanes.count; ++i) {
        lanes.ray[left] = lanes.ray[i];
        left += tree_->length(lanes.ray[i]) >= shortest;
    }
    if (left == 0) return;
    lanes.count = left;
    std::fill(lanes.ray + left, std::end(lanes.ray), lanes.ray[0]);
    kernels_.walkRays(*state_, *rays_, lanes, slice);
}

template <int Dim>
void BeamWalk<Dim>::walkLone(const RayRun<Dim>& run) {
    const RayLine<Dim> line(
        origin_, RayLine<Dim>::unitsOf(rays_->geometry(), rays_->end(run.first)));
    state_->addresses.reserveMore(static_cast<std::size_t>(line.steps()));
    kernels_.walk(*state_, line, 0);
    state_->flush(1);
}

template <int Dim>
void BeamWalk<Dim>::addHits(const Node& node) {
    for (std::uint32_t i = node.first; i < node.last; ++i) {
        const RayRun<Dim>& run = tree_->runs()[i];
        addHits(run.first, run.first + run.count);
    }
}

template <int Dim>
void BeamWalk<Dim>::addHits(std::size_t begin, std::size_t end) {
    const RayEnd* const kinds = rays_->kinds();
    BlockKey<Dim> current{};
    std::uint8_t *hits = nullptr, *misses = nullptr;  // consecutive points share blocks
    std::uint32_t block = 0;
    const bool dense = state_->directory.dense();
    for (std::size_t i = begin; i < end; ++i) {
        if (kinds[i] != RayEnd::hit) continue;
        std::size_t local;
        bool same = hits != nullptr;
        if (dense) {
            same &= ends_->block(i) == block;
            block = ends_->block(i);
            local = ends_->local(i);
        } else {
            const Cell<Dim> cell = rays_->geometry().cellOf(rays_->end(i));
            same &= blockOf<Dim>(cell) == current;
            current = blockOf<Dim>(cell);
            local = static_cast<std::size_t>(indexInBlock<Dim>(cell));
        }
        if (!same) {
            if (dense) current = blockOf<Dim>(rays_->geometry().cellOf(rays_->end(i)));
            const std::uint32_t own = state_->batchBlock(current);
            hits = state_->batch.hitsOf(own);
            misses = state_->batch.missesOf(own);
        }
        const unsigned h = hits[local] + (hits[local] != UpdateBatch<Dim>::kMaxCount);
        hits[local] = static_cast<std::uint8_t>(h);
        if (state_->sureHit(h)) misses[local] = UpdateBatch<Dim>::kMaxCount;
    }
}

template class BeamWalk<2>;
template class BeamWalk<3>;

}  // namespace superray
