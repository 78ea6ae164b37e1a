// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Bounds of a scan, and samples that tell what kind of scan it is.

#include <superray/core/ray_bundle.h>

#include "counting/block_directory.h"

#include <algorithm>
#include <iterator>

namespace superray {

/// Inclusive cell bounds of all origins and end points. \pre !rays.empty()
template <int Dim>
struct ScanBounds {
    Cell<Dim> lowest, highest;
    explicit ScanBounds(const RayBundle<Dim>& rays)
        : lowest(rays.geometry().cellOf(rays.lowest())),
          highest(rays.geometry().cellOf(rays.highest())) {}
    BlockBox<Dim> blocks() const { return {blockOf<Dim>(lowest), blockOf<Dim>(highest)}; }
};

/// Length along the major axis [cells] of an average ray of [first, last), by a
/// sample. \pre first < last; the rays have the common origin
template <int Dim>
double typicalLength(const RayBundle<Dim>& rays, std::size_t first, std::size_t last) {
    constexpr std::size_t kSample = 64;  // rays; any such number does
    const std::size_t step = (last - first) / kSample + 1;
    double sum = 0;
    std::size_t n = 0;
    for (std::size_t i = first; i < last; i += step, ++n)
        sum += (rays.end(i) - rays.commonOrigin()).template lpNorm<Eigen::Infinity>();
    return rays.geometry().scaled(sum / static_cast<double>(n));
}

/// Whether rays go to at least four sides (each a direction of an axis), by a sample:
/// those of a lidar, not those of a camera. \pre the rays have the common origin
template <int Dim>
bool goAllAround(const RayBundle<Dim>& rays) {
    constexpr std::size_t kSample = 128;  // rays
    constexpr std::size_t kLeast = 4;     // of them, for a side to count
    constexpr std::ptrdiff_t kLeastSides = 4;
    std::size_t sides[2 * Dim] = {};
    const std::size_t step = rays.size() / kSample + 1;
    for (std::size_t i = 0; i < rays.size(); i += step) {
        const Point<Dim> ray = rays.end(i) - rays.commonOrigin();
        Eigen::Index axis = 0;
        ray.cwiseAbs().maxCoeff(&axis);
        ++sides[2 * axis + (ray[axis] < 0 ? 1 : 0)];
    }
    return std::count_if(std::begin(sides), std::end(sides),
                         [](std::size_t n) { return n >= kLeast; }) >= kLeastSides;
}

}  // namespace superray
