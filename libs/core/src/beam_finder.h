#pragma once
// The rays of a scan, shared out to beams.

#include "beam.h"

#include <vector>

namespace superray {

template <int Dim>
class BeamFinder {
 public:
    /// Finds beams that are about a cell wide at the end of a typical ray. Takes
    /// neighbours in the sensor's order, if that is good enough; otherwise sorts
    /// the rays by direction. \pre the rays have the common origin
    void find(const RayBundle<Dim>& rays);

    const std::vector<BeamRays<Dim>>& beams() const { return beams_; }
    /// Length of the i-th ray along its dominant axis [cells], roughly.
    float length(std::size_t i) const {
        return sorted_ ? sortedDirections_.length[i] : directions_.length[i];
    }
    /// Number of the i-th ray in the order of the beams.
    std::uint32_t ray(std::size_t i) const {
        return sorted_ ? order_[i] : static_cast<std::uint32_t>(i);
    }

 private:
    void gather(const RayDirections<Dim>& directions, float widest);
    void sort(int bins);

    RayDirections<Dim> directions_, sortedDirections_;
    std::vector<BeamRays<Dim>> beams_;
    bool sorted_ = false;
    std::vector<std::uint32_t> bins_, starts_, order_;
};

}  // namespace superray
