#include "horizon_walk.h"

#include <algorithm>
#include <cmath>

namespace superray {
namespace {

/// Rays are walked in rounds of some of these classes, by ray number: a prime, so
/// that the rays of a class are spread over rows and columns of any sensor.
constexpr std::size_t kClasses = 37;
/// Classes per round; the last round has all that are left.
constexpr std::size_t kRounds[] = {1, 1, 2, 4, 8};

/// Looking around again must be likely to save so many times its work.
static const double TF = getenv("TF") ? atof(getenv("TF")) : 1; static const int ML = getenv("ML") ? atoi(getenv("ML")) : 7; static const double kWorthIt = getenv("KW") ? atof(getenv("KW")) : 4;

/// Addresses gathered before they are counted: enough to keep the counting loop
/// free of mispredictions, few enough to stay in the L1 cache.
constexpr std::size_t kFlushAt = 2048;

template <int Dim>
double typicalLength(const RayBundle<Dim>& rays, std::size_t first, std::size_t last) {
    const std::size_t step = (last - first) / 64 + 1;
    double sum = 0;
    std::size_t n = 0;
    for (std::size_t i = first; i < last; i += step, ++n)
        sum += (rays.end(i) - rays.commonOrigin()).template lpNorm<Eigen::Infinity>();
    return rays.geometry().scaled(sum / static_cast<double>(n));
}

}  // namespace

template <int Dim>
void HorizonWalk<Dim>::begin(const RayBundle<Dim>& rays, const SaturationSource<Dim>* map,
                             WalkState<Dim>& state) {
    static const WalkKernels<Dim> best = bestKernels<Dim>(), portable = portableKernels<Dim>();
    kernels_ = state.directory.dense() ? best : portable;
    rays_ = &rays;
    map_ = map;
    state_ = &state;
    culled_ = 0;
    origin_ = RayLine<Dim>::unitsOf(rays.geometry(), rays.commonOrigin());
    for (std::uint32_t kind = 0; kind < waiting_.size(); ++kind) waiting_[kind].kind = kind;
}

template <int Dim>
void HorizonWalk<Dim>::walk(std::size_t first, std::size_t last) {
    if (first == last) return;
    first_ = first;
    const std::size_t count = last - first;
    chooseTiles(first, last);
    directions_.resize(count);
    kernels_.findDirections(*rays_, first, last, directions_);
    horizon_.reset(directions_.tiles, origin_);
    for (std::size_t i = 0; i < count; ++i)
        horizon_.addRay(directions_.tile[i], directions_.extent[i]);
    horizon_.completeReach();
    addHits(first, last);

    region_.reset(state_->directory.box());
    lookAround();
    bool done[kClasses] = {};
    std::size_t next = 0, walked = 0;
    const std::uint64_t before = state_->traversed;
    for (const std::size_t classes : kRounds) {
        // Classes far apart, so that the rays of a round are.
        for (std::size_t c = 0; c < classes; ++c, next = (next + 14) % kClasses) {
            done[next] = true;
            for (std::size_t i = next; i < count; i += kClasses)
                walkRay(static_cast<std::uint32_t>(i));
        }
        walked += classes;
        for (RayLanes& lanes : waiting_) walkLanes(lanes);
        state_->flush(1);
        const double visits = static_cast<double>(state_->traversed - before);
        const double left = visits / static_cast<double>(walked) *
                            static_cast<double>(kClasses - walked);
        if (left < kWorthIt * static_cast<double>(region_.work())) break;
        lookAround();
    }
    for (std::size_t i = 0; i < count;)
        for (std::size_t c = 0; c < kClasses && i < count; ++c, ++i)
            if (!done[c]) walkRay(static_cast<std::uint32_t>(i));
    for (RayLanes& lanes : waiting_) walkLanes(lanes);
    state_->flush(1);
}

/// Tiles about as wide as a cell at the end of a typical ray.
template <int Dim>
void HorizonWalk<Dim>::chooseTiles(std::size_t first, std::size_t last) {
    const double length = typicalLength(*rays_, first, last);
    int levels = 1;
    while (levels < DirectionTiles<Dim>::kMostLevels && (1 << levels) < TF * length && levels < ML) ++levels;
    directions_.tiles.levels = levels;
}

template <int Dim>
void HorizonWalk<Dim>::lookAround() {
    region_.build(rays_->geometry().cellOf(rays_->commonOrigin()), *state_, map_, horizon_);
}

/// \param ray number among the directions
template <int Dim>
void HorizonWalk<Dim>::walkRay(std::uint32_t ray) {
    const std::uint32_t tile = directions_.tile[ray];
    const std::int32_t from = horizon_.firstOpen(tile);
    culled_ += from > 0;
    if (tile == directions_.tiles.lone()) {
        const RayLine<Dim> line(
            origin_, RayLine<Dim>::unitsOf(rays_->geometry(), rays_->end(first_ + ray)));
        state_->addresses.reserveMore(static_cast<std::size_t>(line.steps()));
        kernels_.walk(*state_, line, 0);
        return;
    }
    const std::uint32_t kind = tile / directions_.tiles.perKind();
    if (from > directions_.extent[ray][kind & 3]) return;
    RayLanes& lanes = waiting_[kind];
    lanes.ray[lanes.count] = static_cast<std::uint32_t>(first_) + ray;
    lanes.from[lanes.count] = from;
    if (++lanes.count == 8) walkLanes(lanes);
}

template <int Dim>
void HorizonWalk<Dim>::walkLanes(RayLanes& lanes) {
    if (lanes.count == 0) return;
    if (state_->addresses.size() >= kFlushAt) state_->flush(1);
    std::fill(lanes.ray + lanes.count, std::end(lanes.ray), lanes.ray[0]);
    kernels_.walkRays(*state_, *rays_, lanes);
    lanes.count = 0;
}

/// Counts hits. Cells with enough of them need no misses any more.
template <int Dim>
void HorizonWalk<Dim>::addHits(std::size_t first, std::size_t last) {
    const bool dense = state_->directory.dense();
    if (dense) {
        ends_.resize(last - first);
        kernels_.findEnds(*rays_, first, last, state_->directory, ends_);
    }
    const RayEnd* const kinds = rays_->kinds();
    BlockKey<Dim> current{};
    std::uint8_t *hits = nullptr, *misses = nullptr;  // consecutive points share blocks
    std::uint32_t block = 0;
    for (std::size_t i = first; i < last; ++i) {
        if (kinds[i] != RayEnd::hit) continue;
        std::size_t local;
        bool same = hits != nullptr;
        if (dense) {
            same &= ends_.block(i - first) == block;
            block = ends_.block(i - first);
            local = ends_.local(i - first);
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

template class HorizonWalk<2>;
template class HorizonWalk<3>;

}  // namespace superray
