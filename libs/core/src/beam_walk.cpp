#include "beam_walk.h"

namespace superray {
namespace {

/// Rays of a beam that are walked between two looks ahead: one vector's worth.
constexpr std::size_t kRaysPerLook = 8;

std::size_t stridesOf(std::size_t rays) {
    return (rays + kRaysPerLook - 1) / kRaysPerLook;
}

}  // namespace

template <int Dim>
void BeamWalk<Dim>::walk(const RayBundle<Dim>& rays, const BeamFinder<Dim>& finder,
                         std::size_t begin, std::size_t end, WalkState<Dim>& state) {
    static const WalkKernels<Dim> best = bestKernels<Dim>(), portable = portableKernels<Dim>();
    kernels_ = state.directory.dense() ? best : portable;
    rays_ = &rays;
    finder_ = &finder;
    state_ = &state;
    culled_ = 0;
    if (begin == end) return;
    const std::vector<BeamRays<Dim>>& beams = finder.beams();
    addHits(beams[begin].begin, beams[end - 1].end);
    origin_ = RayLine<Dim>::unitsOf(rays.geometry(), rays.commonOrigin());

    // First some rays of each beam: evenly spread ones, for these saturate the
    // most. Then, where that was not enough, the others.
    open_.clear();
    for (std::size_t b = begin; b < end; ++b) {
        BeamRays<Dim> beam = beams[b];
        beam.slice = lookAhead(beam);
        if (beam.slice < 0) {
            culled_ += beam.end - beam.begin;
            continue;
        }
        const std::size_t strides = stridesOf(beam.end - beam.begin);
        walkRays(beam, 0, strides);
        if (strides > 1) open_.push_back(beam);
    }
    for (BeamRays<Dim>& beam : open_) {
        const std::size_t strides = stridesOf(beam.end - beam.begin);
        for (std::size_t s = 1; s < strides; ++s) {
            beam.slice = lookAhead(beam);
            if (beam.slice < 0) {
                culled_ += (beam.end - beam.begin) / strides * (strides - s);
                break;
            }
            walkRays(beam, s, strides);
        }
    }
    state.flush(1);
}

/// First slice, from beam.slice on, that has something to tell; -1 if none.
template <int Dim>
std::int32_t BeamWalk<Dim>::lookAhead(const BeamRays<Dim>& rays) {
    if (rays.kind == RayDirections<Dim>::kLone) return 0;
    state_->flush(1);
    const Beam<Dim> beam(rays, origin_);
    const std::int32_t slice =
        kernels_.firstUnsaturated(*state_, beam, rays.slice, beam.slices);
    return slice == beam.slices ? -1 : slice;
}

/// Walks every stride-th ray of the beam, from beam.slice on.
template <int Dim>
void BeamWalk<Dim>::walkRays(const BeamRays<Dim>& beam, std::size_t first,
                             std::size_t stride) {
    if (beam.kind == RayDirections<Dim>::kLone) {
        const RayLine<Dim> line(rays_->geometry(), rays_->commonOrigin(),
                                rays_->end(finder_->ray(beam.begin)));
        state_->addresses.reserveMore(static_cast<std::size_t>(line.steps()));
        kernels_.walk(*state_, line, 0, line.slices());
        return;
    }
    static int kLaneSlices = getenv("LS") ? atoi(getenv("LS")) : 12;
    if (beam.length - static_cast<float>(beam.slice) > static_cast<float>(kLaneSlices)) {
        culled_ += beam.slice > 0 ? (beam.end-beam.begin-first+stride-1)/stride : 0;
        const float shortest = beam.slice > 1 ? static_cast<float>(beam.slice - 1) * 0.99999f : 0;
        for (std::size_t i = beam.begin + first; i < beam.end; i += stride) {
            if (finder_->length(i) < shortest) continue;
            const RayLine<Dim> line(origin_, RayLine<Dim>::unitsOf(rays_->geometry(),
                                rays_->end(finder_->ray(i))));
            const std::int32_t slices = line.slices();
            if (beam.slice >= slices) continue;
            state_->addresses.reserveMore(static_cast<std::size_t>(line.steps()));
            kernels_.walk(*state_, line, beam.slice, slices);
        }
        return;
    }
    RayLanes lanes;
    lanes.kind = beam.kind;
    // Rays that end before that slice need not be looked at.
    const float shortest = beam.slice > 1 ? static_cast<float>(beam.slice - 1) * 0.99999f : 0;
    for (std::size_t i = beam.begin + first; i < beam.end; i += stride) {
        if (finder_->length(i) >= shortest) lanes.ray[lanes.count++] = finder_->ray(i);
    }
    if (lanes.count == 0) return;
    for (int i = lanes.count; i < 8; ++i) lanes.ray[i] = lanes.ray[0];
    culled_ += beam.slice > 0 ? static_cast<std::size_t>(lanes.count) : 0;
    // At most three cells of each ray in each slice.
    const auto slices = static_cast<std::size_t>(beam.length) + 3;
    state_->addresses.reserveMore(3 * kRaysPerLook * slices);
    kernels_.walkLanes(*state_, *rays_, lanes, beam.slice);
}

template <int Dim>
void BeamWalk<Dim>::addHits(std::size_t begin, std::size_t end) {
    BlockKey<Dim> current{};
    std::uint8_t* hits = nullptr;  // consecutive points often share a block
    for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t ray = finder_->ray(i);
        if (rays_->kinds()[ray] != RayEnd::hit) continue;
        const Cell<Dim> cell = rays_->geometry().cellOf(rays_->end(ray));
        const BlockKey<Dim> key = blockOf<Dim>(cell);
        if (hits == nullptr || key != current) {
            hits = state_->batch.hitsOf(state_->batchBlock(key));
            current = key;
        }
        std::uint8_t& count = hits[indexInBlock<Dim>(cell)];
        count = static_cast<std::uint8_t>(count + (count != 255));
    }
    state_->forgetMissesOfSureHits();
}

template class BeamWalk<2>;
template class BeamWalk<3>;

}  // namespace superray
