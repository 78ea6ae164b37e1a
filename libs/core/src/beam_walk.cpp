#include "beam_walk.h"

namespace superray {
namespace {

/// Rays of a beam: enough to repay looking ahead of them.
std::size_t kBeamRays = getenv("BR") ? atoi(getenv("BR")) : 16;

/// Rays walked between two looks ahead.
std::size_t kRaysPerLook = getenv("RPL") ? atoi(getenv("RPL")) : 6;

}  // namespace

template <int Dim>
BeamWalk<Dim>::BeamWalk() : kernels_(bestKernels<Dim>()) {}

template <int Dim>
void BeamWalk<Dim>::walk(const RayBundle<Dim>& rays, const std::uint32_t* begin,
                         const std::uint32_t* end, WalkState<Dim>& state) {
    static const WalkKernels<Dim> portable = portableKernels<Dim>();
    kernels_ = state.directory.dense() ? bestKernels<Dim>() : portable;
    culled_ = 0;
    addHits(rays, begin, end, state);
    lines_.origin = RayLine<Dim>::unitsOf(rays.geometry(), rays.commonOrigin());
    while (begin < end) {
        const std::size_t count =
            std::min(static_cast<std::size_t>(end - begin), LineBatch<Dim>::kSize);
        for (int a = 0; a < Dim; ++a) {
            const double* ends = rays.ends(a);
            for (std::size_t i = 0; i < count; ++i) lines_.end[a][i] = ends[begin[i]];
        }
        lines_.count = count;
        kernels_.setUp(rays.geometry(), lines_);
        for (std::size_t from = 0; from < count;) {
            std::size_t to = from + 1;
            while (to < count && to - from < kBeamRays && lines_.kind[to] == lines_.kind[from])
                ++to;
            walkBeam(from, to, state);
            from = to;
        }
        begin += count;
    }
    state.flush(1);
}

template <int Dim>
void BeamWalk<Dim>::walkBeam(std::size_t from, std::size_t to, WalkState<Dim>& state) {
    const Beam<Dim> beam(lines_, from, to);
    // Evenly spread rays first: ray i, i + strides, i + 2 strides, ...
    const std::size_t rays = to - from;
    const std::size_t strides = (rays + kRaysPerLook - 1) / kRaysPerLook;
    std::int32_t slice = 0;
    std::size_t walked = 0;
    for (std::size_t s = 0; s < strides; ++s) {
        state.flush(1);
        slice = kernels_.firstUnsaturated(state, beam, slice, beam.slices);
        if (slice == beam.slices) break;
        for (std::size_t i = from + s; i < to; i += strides, ++walked) walkRay(i, slice, state);
    }
    culled_ += rays - walked;
}

template <int Dim>
void BeamWalk<Dim>::walkRay(std::size_t i, std::int32_t from, WalkState<Dim>& state) {
    const RayLine<Dim> line = lines_.line(i);
    const std::int32_t slices = line.slices();
    if (from >= slices) {
        ++culled_;
        return;
    }
    culled_ += from > 0;
    state.addresses.reserveMore(static_cast<std::size_t>(line.steps()));
    kernels_.walk(state, line, from, slices);
}

template <int Dim>
void BeamWalk<Dim>::addHits(const RayBundle<Dim>& rays, const std::uint32_t* begin,
                            const std::uint32_t* end, WalkState<Dim>& state) {
    BlockKey<Dim> current{};
    std::uint8_t* hits = nullptr;  // consecutive points often share a block
    for (const std::uint32_t* i = begin; i != end; ++i) {
        if (rays.kinds()[*i] != RayEnd::hit) continue;
        const Cell<Dim> cell = rays.geometry().cellOf(rays.end(*i));
        const BlockKey<Dim> key = blockOf<Dim>(cell);
        if (hits == nullptr || key != current) {
            hits = state.batch.hitsOf(state.batchBlock(key));
            current = key;
        }
        std::uint8_t& count = hits[indexInBlock<Dim>(cell)];
        count = static_cast<std::uint8_t>(count + (count != 255));
    }
    state.forgetMissesOfSureHits();
}

template class BeamWalk<2>;
template class BeamWalk<3>;

}  // namespace superray
