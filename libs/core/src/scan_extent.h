#pragma once
// How far a scan goes.

#include <superray/core/ray_bundle.h>

#include "block_directory.h"

namespace superray {

/// Inclusive cell bounds of all origins and end points. \pre !rays.empty()
template <int Dim>
struct ScanExtent {
    Cell<Dim> lowest, highest;
    explicit ScanExtent(const RayBundle<Dim>& rays)
        : lowest(rays.geometry().cellOf(rays.lowest())),
          highest(rays.geometry().cellOf(rays.highest())) {}
    BlockBox<Dim> blocks() const { return {blockOf<Dim>(lowest), blockOf<Dim>(highest)}; }
};

/// Length along the dominant axis [cells] of an average ray of [first, last), by a
/// sample. \pre first < last; the rays have the common origin
template <int Dim>
double typicalLength(const RayBundle<Dim>& rays, std::size_t first, std::size_t last) {
    const std::size_t step = (last - first) / 64 + 1;
    double sum = 0;
    std::size_t n = 0;
    for (std::size_t i = first; i < last; i += step, ++n)
        sum += (rays.end(i) - rays.commonOrigin()).template lpNorm<Eigen::Infinity>();
    return rays.geometry().scaled(sum / static_cast<double>(n));
}

}  // namespace superray
