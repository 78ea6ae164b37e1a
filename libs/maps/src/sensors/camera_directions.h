// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file camera_directions.h
/// Where each pixel of a range camera looks: pinhole or fisheye, undistorted.

#include <mrpt/img/TCamera.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace superray {

/// What an entry of a range image measures.
enum class RangeKind : std::uint8_t {
    depth,  ///< distance along the optical axis (+X of the sensor)
    range   ///< distance to the sensor
};

/// One vector per pixel, row by row, sensor frame (+X forward, +Y left, +Z up):
/// times the measured value [m] it is the point. NaN where the model has no
/// direction. Depth: x = 1; range: unit length.
using PixelDirections = std::vector<Eigen::Vector3f>;

/// Directions of a camera; those of the last few cameras are kept. Thread-safe.
/// \throws std::invalid_argument unless the focal lengths are > 0
std::shared_ptr<const PixelDirections> pixelDirections(const mrpt::img::TCamera& camera,
                                                       RangeKind kind);

}  // namespace superray
