#pragma once
// Method `auto`: neighbouring rays are walked as beams, from where the map and
// this scan have not yet saturated every cell that the beam can visit.

#include "walk_kernel.h"

namespace superray {

/// One thread's part of a scan.
template <int Dim>
class BeamWalk {
 public:
    BeamWalk();

    /// Walks the rays whose numbers are [begin, end) into `state`, misses and
    /// hits. Neighbours in direction should be neighbours in this order.
    /// \pre state.reset() and state.countMapSaturation() were called; the rays
    /// have the common origin
    void walk(const RayBundle<Dim>& rays, const std::uint32_t* begin,
              const std::uint32_t* end, WalkState<Dim>& state);

    /// Rays of the last walk() that were cut short or left out.
    std::uint64_t culled() const { return culled_; }

 private:
    void walkBeam(std::size_t from, std::size_t to, WalkState<Dim>& state);
    void walkRay(std::size_t i, std::int32_t from, WalkState<Dim>& state);
    void addHits(const RayBundle<Dim>& rays, const std::uint32_t* begin,
                 const std::uint32_t* end, WalkState<Dim>& state);

    WalkKernels<Dim> kernels_;
    LineBatch<Dim> lines_;
    std::uint64_t culled_ = 0;
};

}  // namespace superray
