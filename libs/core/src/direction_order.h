#pragma once
// The rays of a scan, neighbours in direction next to each other.

#include "walk_kernel.h"

#include <vector>

namespace superray {

template <int Dim>
class DirectionOrder {
 public:
    /// Sorts the rays into bins of direction, a few cells wide at the end of a
    /// typical ray, but no narrower than the number of rays repays.
    /// \pre rays have the common origin
    void sort(const RayBundle<Dim>& rays);

    /// Numbers of the rays from the i-th on.
    const std::uint32_t* begin(std::size_t i) const { return order_.data() + i; }

 private:
    std::vector<std::uint32_t> bins_, starts_, order_;
};

}  // namespace superray
