#include "horizon_walk.h"

#include "scan_extent.h"

#include <algorithm>

namespace superray {
namespace {

/// Rays are told apart by their number modulo a prime, so that those of a class are
/// spread over rows and columns of any sensor. Some of the classes are walked
/// first: what these saturate, the others are spared.
constexpr std::size_t kClasses = 37, kFirstClasses = 4, kBetweenFirst = 14, kLaterClass = 21;

/// Looking around again must be likely to save so many times its work.
constexpr double kWorthIt = 4;
/// Rays per tile from which on this may pay at all: rays that are walked out of
/// the sensor's order find less in the cache.
constexpr std::size_t kDense = 5;

/// Most work of looking around, per ray: about what it takes to walk a ray through
/// as many cells.
constexpr std::size_t kWorkPerRay = 6;

/// Addresses gathered before they are counted: enough to keep the counting loop
/// free of mispredictions, few enough to stay in the L1 cache.
constexpr std::size_t kFlushAt = 2048;

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
    horizon_.reset(directions_.tiles, origin_);
    for (std::size_t at = 0; at < count; at += RayEnds::kMost) {
        const std::size_t n = std::min(RayEnds::kMost, count - at);
        kernels_.findDirections(*rays_, first + at, n, state_->directory, directions_, at, ends_);
        horizon_.addRays(directions_.tile.data() + at, ends_, n);
        countHits(first + at, n);
    }
    horizon_.completeReach();
    state_->settleSureHits();

    region_.reset(state_->directory.box());
    lookAround(count);
    bool done[kClasses] = {};
    if (count > kDense * horizon_.tilesWithRays()) walkFirst(count, done);
    chosen_.resize(count + kClasses);
    std::size_t chosen = 0;
    for (std::size_t i = 0; i < count; i += kClasses)
        for (std::size_t c = 0; c < std::min(kClasses, count - i); ++c) {
            chosen_[chosen] = static_cast<std::uint32_t>(i + c);
            chosen += static_cast<std::size_t>(!done[c]) & hasToTell(i + c);
        }
    culled_ += count;
    walkChosen(chosen);
}

/// Walks some classes of rays and looks around again, if that is worth while.
template <int Dim>
void HorizonWalk<Dim>::walkFirst(std::size_t count, bool* done) {
    for (std::size_t i = 0, c = 0; i < kFirstClasses; ++i, c = (c + kBetweenFirst) % kClasses) {
        done[c] = true;
        walkClass(c, count);
    }
    const double left = slicesOfClass(kLaterClass, count) * (kClasses - kFirstClasses);
    if (left > kWorthIt * static_cast<double>(region_.work())) lookAround(count);
}

/// Slices of rays in which there may be something to tell.
template <int Dim>
double HorizonWalk<Dim>::slicesOfClass(std::size_t c, std::size_t count) const {
    double slices = 0;
    for (std::size_t i = c; i < count; i += kClasses)
        slices += std::max(0, lastSlice(i) + 1 - horizon_.firstOpen(directions_.tile[i]));
    return slices;
}

/// The slice in which a ray of the part ends.
template <int Dim>
std::int32_t HorizonWalk<Dim>::lastSlice(std::size_t ray) const {
    return directions_.aim[ray][2];
}

/// Whether a ray of the part has something to tell, as far as the horizon knows.
template <int Dim>
bool HorizonWalk<Dim>::hasToTell(std::size_t ray) const {
    return horizon_.firstOpen(directions_.tile[ray]) <= lastSlice(ray);
}

template <int Dim>
void HorizonWalk<Dim>::walkClass(std::size_t c, std::size_t count) {
    chosen_.resize(count / kClasses + 1);
    std::size_t chosen = 0;
    for (std::size_t i = c; i < count; i += kClasses) {
        chosen_[chosen] = static_cast<std::uint32_t>(i);
        chosen += hasToTell(i);
    }
    walkChosen(chosen);
}

/// Walks the first `count` of chosen_.
template <int Dim>
void HorizonWalk<Dim>::walkChosen(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t ray = chosen_[i];
        const std::uint32_t tile = directions_.tile[ray];
        const std::int32_t from = horizon_.firstOpen(tile);
        culled_ -= from == 0;
        if (tile == directions_.tiles.lone()) {
            const RayLine<Dim> line(
                origin_, RayLine<Dim>::unitsOf(rays_->geometry(), rays_->end(first_ + ray)));
            state_->addresses.reserveMore(static_cast<std::size_t>(line.steps()));
            kernels_.walk(*state_, line, 0);
            continue;
        }
        RayLanes& lanes = waiting_[directions_.tiles.kindOf(tile)];
        lanes.ray[lanes.count] = static_cast<std::uint32_t>(first_) + ray;
        lanes.from[lanes.count] = from;
        if (++lanes.count == 8) walkLanes(lanes);
    }
    for (RayLanes& lanes : waiting_) walkLanes(lanes);
    state_->flush(1);
}

/// Tiles about as wide as a cell at the end of a typical ray; finer ones where few
/// are enough for that.
template <int Dim>
void HorizonWalk<Dim>::chooseTiles(std::size_t first, std::size_t last) {
    constexpr int kFew = 5;
    const double length = typicalLength(*rays_, first, last);
    int levels = 1;
    while (levels < DirectionTiles<Dim>::kMostLevels &&
           (1 << levels) < (levels < kFew ? 2 * length : length))
        ++levels;
    directions_.tiles.levels = levels;
}

template <int Dim>
void HorizonWalk<Dim>::lookAround(std::size_t count) {
    region_.build(rays_->geometry().cellOf(rays_->commonOrigin()), *state_, map_, horizon_,
                  kWorkPerRay * count);
}

template <int Dim>
void HorizonWalk<Dim>::walkLanes(RayLanes& lanes) {
    if (lanes.count == 0) return;
    if (state_->addresses.size() >= kFlushAt) state_->flush(1);
    std::fill(lanes.ray + lanes.count, std::end(lanes.ray), lanes.ray[0]);
    kernels_.walkRays(*state_, *rays_, lanes);
    lanes.count = 0;
}

/// Counts the hits of the rays of ends_.
template <int Dim>
void HorizonWalk<Dim>::countHits(std::size_t first, std::size_t count) {
    if (state_->directory.dense()) {
        hitsMatter_.learn(hitsMatter_.unpredictable()
                              ? countInTurns<Branches::none>(first, count)
                              : countInTurns<Branches::predicted>(first, count),
                          count);
        return;
    }
    for (std::size_t i = first; i < first + count; ++i) {
        if (rays_->kind(i) != RayEnd::hit) continue;
        const Cell<Dim> cell = rays_->geometry().cellOf(rays_->end(i));
        std::uint8_t& hits =
            state_->hitsOf(blockOf<Dim>(cell))[indexInBlock<Dim>(cell)];
        if (!state_->sureHit(hits)) ++hits;
    }
}

/// Neighbours often end in the same cell, and would wait for each other's stores: so
/// rays are taken from several places in turn.
/// \return number of hits that changed something
template <int Dim>
template <Branches branches>
std::size_t HorizonWalk<Dim>::countInTurns(std::size_t first, std::size_t count) {
    const RayEnd* const kinds = rays_->kinds() + first;
    struct Place {
        std::uint32_t block = ~std::uint32_t{0};  // consecutive points share blocks
        std::size_t offset = 0;
    };
    Place places[4];
    std::uint8_t* arena = nullptr;
    std::size_t changes = 0;
    const auto add = [&](Place& place, std::size_t i) {
        if (kinds[i] != RayEnd::hit) return;
        if (ends_.block[i] != place.block) {
            place.block = ends_.block[i];
            const Cell<Dim> cell = rays_->geometry().cellOf(rays_->end(first + i));
            const std::uint8_t* const hits = state_->hitsOf(blockOf<Dim>(cell));
            arena = state_->batch.hitArena();
            place.offset = static_cast<std::size_t>(hits - arena);
        }
        std::uint8_t& hits = arena[place.offset + ends_.local[i]];
        const bool change = !state_->sureHit(hits);
        changes += change;
        if (branches == Branches::none || change)
            hits = static_cast<std::uint8_t>(hits + change);
    };
    const std::size_t quarter = count / 4;
    for (std::size_t i = 0; i < quarter; ++i) {
        add(places[0], i);
        add(places[1], quarter + i);
        add(places[2], 2 * quarter + i);
        add(places[3], 3 * quarter + i);
    }
    for (std::size_t i = 4 * quarter; i < count; ++i) add(places[3], i);
    return changes;
}

template class HorizonWalk<2>;
template class HorizonWalk<3>;

}  // namespace superray
