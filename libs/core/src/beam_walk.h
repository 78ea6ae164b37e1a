#pragma once
// Method `auto`: neighbouring rays are walked as beams, from where the map and
// this scan have not yet saturated every cell that the beam can visit.

#include "beam_finder.h"
#include "walk_kernel.h"

#include <vector>

namespace superray {

/// One thread's part of a scan.
template <int Dim>
class BeamWalk {
 public:
    /// Walks one share of the beams into `state`, misses and hits.
    /// \pre state.reset() and state.countMapSaturation() were called
    void walk(const RayBundle<Dim>& rays, const BeamFinder<Dim>& finder, std::size_t share,
              WalkState<Dim>& state);

    /// Rays of the last walk() that were cut short or left out.
    std::uint64_t culled() const { return culled_; }

 private:
    std::int32_t lookAhead(const BeamRays<Dim>& beam);
    void walkRays(const BeamRays<Dim>& beam, std::size_t first, std::size_t stride);
    void addHits(std::size_t begin, std::size_t end);

    const RayBundle<Dim>* rays_ = nullptr;
    const BeamFinder<Dim>* finder_ = nullptr;
    WalkState<Dim>* state_ = nullptr;
    WalkKernels<Dim> kernels_;
    Units<Dim> origin_{};
    std::vector<BeamRays<Dim>> open_;
    std::uint64_t culled_ = 0;
};

}  // namespace superray
