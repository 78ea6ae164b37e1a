#pragma once
// Method `auto`: neighbouring rays are walked as beams, from where the map and
// this scan have not yet saturated every cell that the beam can visit.

#include "beam_finder.h"
#include "walk_kernel.h"

#include <vector>

namespace superray {

/// One thread's part of a scan: begin(), addHits(), then any number of
/// walkFirst(), then any number of walkRest(), then end().
template <int Dim>
class BeamWalk {
 public:
    using Beams = std::vector<BeamRays<Dim>>;

    /// \pre state.reset() and state.countMapSaturation() were called
    void begin(const RayBundle<Dim>& rays, const BeamFinder<Dim>& finder,
               WalkState<Dim>& state);

    /// Counts the hits of all rays of some beams. Those that make misses
    /// irrelevant spare the walks.
    void addHits(const Beams& beams);

    /// Walks some rays of each of the beams [first, last): evenly spread ones,
    /// for these saturate the most.
    /// \param open gets the beams that have more to tell
    void walkFirst(const BeamRays<Dim>* first, const BeamRays<Dim>* last, Beams& open);

    /// Walks what else the open beams have to tell.
    void walkRest(Beams& open);

    void end() { state_->flush(1); }

    /// Rays that were cut short or left out, since begin().
    std::uint64_t culled() const { return culled_; }

 private:
    std::int32_t lookAhead(const BeamRays<Dim>& beam);
    void walkRays(const BeamRays<Dim>& beam, std::size_t first, std::size_t stride);

    const RayBundle<Dim>* rays_ = nullptr;
    const BeamFinder<Dim>* finder_ = nullptr;
    WalkState<Dim>* state_ = nullptr;
    WalkKernels<Dim> kernels_;
    Units<Dim> origin_{};
    std::uint64_t culled_ = 0;
};

}  // namespace superray
