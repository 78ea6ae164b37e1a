#pragma once
// Hits of a scan's rays, run by run.

#include "threads/surprise.h"
#include "kernels/walk_kernel.h"

#include <array>
#include <cstdint>

namespace superray {

/// Counts hits in a batch, as far as more of them may change something.
template <int Dim>
class HitCounter {
 public:
    /// Counts the hits of some rays from `first` on, at most RayDirections::kMost.
    /// \param directions of these rays
    /// \param starts where runs of rays begin that end alike; one more: where the last ends
    void count(WalkState<Dim>& state, const RayBundle<Dim>& rays, std::size_t first,
               const RayDirections<Dim>& directions, const std::uint32_t* starts,
               std::size_t runs);

 private:
    void findPlaces(WalkState<Dim>& state, const RayBundle<Dim>& rays, std::size_t first,
                    const RayDirections<Dim>& directions, const std::uint32_t* starts,
                    std::size_t runs);
    template <Branches branches>
    std::size_t countInTurns(WalkState<Dim>& state, const std::uint32_t* starts,
                             std::size_t runs) const;

    /// Per run: where its hits are counted, or WalkState::kNoPlace.
    std::array<std::uint32_t, RayDirections<Dim>::kMost> places_;
    Surprise hitsMatter_;
};

}  // namespace superray
