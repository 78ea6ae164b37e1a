// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file canvas.h
/// A depth-buffered picture of flat faces, in software.

#include <mrpt/img/CImage.h>

#include <Eigen/Core>
#include <vector>

namespace superray {

using Rgb = Eigen::Array3f;  ///< linear blend of [0, 1] per channel

/// A parallelogram in picture coordinates: x right, y down [pixels], z towards
/// the viewer [the scene's unit].
struct Face {
    Eigen::Vector3f corner, edge1, edge2;
    Rgb colour;
};

/// A part of a picture, drawn with 2 x 2 samples per pixel.
class Canvas {
 public:
    static constexpr int kSamples = 2;  ///< per pixel and axis

    Canvas(int width, int height);
    int width() const { return width_ / kSamples; }
    int height() const { return height_ / kSamples; }

    /// Draws a face where nothing nearer has been drawn.
    void fill(const Face& face);

    /// Darkens what lies behind its surroundings, so that shapes stand out.
    /// \param unit depth difference that counts as much [the scene's unit]
    void shadeByDepth(float unit);

    /// Averages the samples into `image` at column `left`; where nothing was
    /// drawn the colour goes from `top` to `bottom`.
    void copyTo(mrpt::img::CImage& image, int left, const Rgb& top, const Rgb& bottom) const;

 private:
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(x);
    }

    int width_, height_;  // samples
    std::vector<Rgb> colour_;
    std::vector<float> depth_;
};

}  // namespace superray
