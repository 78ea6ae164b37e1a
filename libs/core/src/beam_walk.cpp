#include "beam_walk.h"

#include <algorithm>
#include <iterator>

namespace superray {
namespace {

/// Rays of a beam that are walked between two looks ahead: one vector's worth.
constexpr std::size_t kRaysPerLook = 8;

/// Rays are walked side by side if no more slices than this are left of them:
/// then few cells are new to each, and starting is what costs.
constexpr float kLaneSlices = 12;

std::size_t stridesOf(std::size_t rays) {
    return (rays + kRaysPerLook - 1) / kRaysPerLook;
}

}  // namespace

template <int Dim>
void BeamWalk<Dim>::begin(const RayBundle<Dim>& rays, const BeamFinder<Dim>& finder,
                          WalkState<Dim>& state) {
    static const WalkKernels<Dim> best = bestKernels<Dim>(), portable = portableKernels<Dim>();
    kernels_ = state.directory.dense() ? best : portable;
    rays_ = &rays;
    finder_ = &finder;
    state_ = &state;
    culled_ = 0;
    origin_ = RayLine<Dim>::unitsOf(rays.geometry(), rays.commonOrigin());
}

template <int Dim>
void BeamWalk<Dim>::walkFirst(const BeamRays<Dim>* first, const BeamRays<Dim>* last,
                              Beams& open) {
    open.clear();
    for (; first != last; ++first) {
        BeamRays<Dim> beam = *first;
        beam.slice = lookAhead(beam);
        if (beam.slice < 0) {
            culled_ += beam.end - beam.begin;
            continue;  // no ray of it has anything to tell but its hit
        }
        const std::size_t strides = stridesOf(beam.end - beam.begin);
        walkRays(beam, 0, strides);
        if (strides > 1) open.push_back(beam);
    }
}

template <int Dim>
void BeamWalk<Dim>::walkRest(Beams& open) {
    for (BeamRays<Dim>& beam : open) {
        const std::size_t strides = stridesOf(beam.end - beam.begin);
        for (std::size_t s = 1; s < strides; ++s) {
            beam.slice = lookAhead(beam);
            if (beam.slice < 0) {
                for (; s < strides; ++s)
                    culled_ += (beam.end - beam.begin - s + strides - 1) / strides;
                break;
            }
            walkRays(beam, s, strides);
        }
    }
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
void BeamWalk<Dim>::walkRays(const BeamRays<Dim>& beam, std::size_t first, std::size_t stride) {
    RayLanes lanes;
    lanes.kind = beam.kind;
    // Rays that end before that slice have nothing to tell.
    const float shortest = 0.99999f * static_cast<float>(beam.slice - 1);
    for (std::size_t i = beam.begin + first; i < beam.end; i += stride) {
        culled_ += beam.slice > 0;
        if (finder_->length(i) >= shortest) lanes.ray[lanes.count++] = finder_->ray(i);
    }
    const float slices = beam.length - static_cast<float>(beam.slice);
    if (beam.kind != RayDirections<Dim>::kLone && slices <= kLaneSlices) {
        if (lanes.count == 0) return;
        std::fill(lanes.ray + lanes.count, std::end(lanes.ray), lanes.ray[0]);
        // At most three cells of each ray in each slice.
        state_->addresses.reserveMore(3 * kRaysPerLook * static_cast<std::size_t>(slices + 3));
        kernels_.walkLanes(*state_, *rays_, lanes, beam.slice);
        return;
    }
    for (int i = 0; i < lanes.count; ++i) {
        const RayLine<Dim> line(
            origin_, RayLine<Dim>::unitsOf(rays_->geometry(), rays_->end(lanes.ray[i])));
        if (beam.slice >= line.slices()) continue;
        state_->addresses.reserveMore(static_cast<std::size_t>(line.steps()));
        kernels_.walk(*state_, line, beam.slice, line.slices());
    }
}

template <int Dim>
void BeamWalk<Dim>::addHits(const Beams& beams) {
    BlockKey<Dim> current{};
    std::uint8_t* hits = nullptr;  // consecutive points often share a block
    const std::size_t end = beams.empty() ? 0 : beams.back().end;
    for (std::size_t i = beams.empty() ? 0 : beams.front().begin; i < end; ++i) {
        const std::uint32_t ray = finder_->ray(i);
        if (rays_->kinds()[ray] != RayEnd::hit) continue;
        const Cell<Dim> cell = rays_->geometry().cellOf(rays_->end(ray));
        const BlockKey<Dim> key = blockOf<Dim>(cell);
        if (hits == nullptr || key != current) {
            hits = state_->batch.hitsOf(state_->batchBlock(key));
            current = key;
        }
        std::uint8_t& count = hits[indexInBlock<Dim>(cell)];
        count = WalkState<Dim>::saturatingAdd(count, 1);
    }
    state_->forgetMissesOfSureHits();
}

template class BeamWalk<2>;
template class BeamWalk<3>;

}  // namespace superray
