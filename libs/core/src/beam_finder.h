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
    /// \param shares of about as many rays, each found by a thread
    void find(const RayBundle<Dim>& rays, std::size_t shares);

    const std::vector<BeamRays<Dim>>& beams(std::size_t share) const { return beams_[share]; }
    /// Length of the i-th ray along its dominant axis [cells], roughly.
    float length(std::size_t i) const {
        return sorted_ ? sortedDirections_.length[i] : directions_.length[i];
    }
    /// Number of the i-th ray in the order of the beams.
    std::uint32_t ray(std::size_t i) const {
        return sorted_ ? order_[i] : static_cast<std::uint32_t>(i);
    }

 private:
    void gather(const RayDirections<Dim>& directions, float widest, std::size_t shares);
    static void gather(const RayDirections<Dim>& directions, float widest, std::size_t begin,
                       std::size_t end, std::vector<BeamRays<Dim>>& beams);
    void sort(int bins, std::size_t shares);

    RayDirections<Dim> directions_, sortedDirections_;
    std::vector<std::vector<BeamRays<Dim>>> beams_;  // per share
    bool sorted_ = false;
    std::vector<std::uint32_t> bins_, order_;
    std::vector<std::vector<std::uint32_t>> starts_;  // per share and bin
};

}  // namespace superray
