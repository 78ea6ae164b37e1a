// SPDX-License-Identifier: BSD-3-Clause
#include "pictures/canvas.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace superray {
namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();

int clampedFloor(float value, int low, int high) {
    return static_cast<int>(
        std::floor(std::clamp(value, static_cast<float>(low), static_cast<float>(high))));
}

}  // namespace

Canvas::Canvas(int width, int height) : width_(width * kSamples), height_(height * kSamples) {
    const auto samples = index(0, height_);
    colour_.resize(samples, Rgb::Zero());
    depth_.resize(samples, kNothing);
}

void Canvas::fill(const Face& face) {
    constexpr auto k = static_cast<float>(kSamples);
    const Eigen::Vector3f scale(k, k, 1);
    const Eigen::Vector3f p = face.corner.cwiseProduct(scale);
    const Eigen::Vector3f u = face.edge1.cwiseProduct(scale);
    const Eigen::Vector3f v = face.edge2.cwiseProduct(scale);
    const float area = u.x() * v.y() - u.y() * v.x();
    if (area == 0) return;  // seen edge-on

    const auto [xLow, xHigh] =
        std::minmax({p.x(), p.x() + u.x(), p.x() + v.x(), p.x() + u.x() + v.x()});
    const auto [yLow, yHigh] =
        std::minmax({p.y(), p.y() + u.y(), p.y() + v.y(), p.y() + u.y() + v.y()});
    if (xHigh < 0 || yHigh < 0) return;
    for (int y = clampedFloor(yLow, 0, height_);
         y < std::min(height_, clampedFloor(yHigh, -1, height_) + 1); ++y) {
        for (int x = clampedFloor(xLow, 0, width_);
             x < std::min(width_, clampedFloor(xHigh, -1, width_) + 1); ++x) {
            const float dx = static_cast<float>(x) + 0.5f - p.x();
            const float dy = static_cast<float>(y) + 0.5f - p.y();
            const float a = (dx * v.y() - dy * v.x()) / area;
            const float b = (u.x() * dy - u.y() * dx) / area;
            if (!(a >= 0 && a <= 1 && b >= 0 && b <= 1)) continue;
            const float depth = p.z() + a * u.z() + b * v.z();
            const auto i = index(x, y);
            if (depth <= depth_[i]) continue;
            depth_[i] = depth;
            colour_[i] = face.colour;
        }
    }
}

void Canvas::shadeByDepth(float unit) {
    constexpr int kDirections[8][2] = {{1, 0},  {1, 1},   {0, 1},  {-1, 1},
                                       {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
    // A near ring draws outlines, wider ones a soft shadow in corners.
    struct Ring {
        int radius;
        float strength;
    };
    constexpr Ring kRings[] = {
        {1 * kSamples, 0.9f}, {5 * kSamples, 0.6f}, {14 * kSamples, 0.5f}};
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) {
            const auto i = index(x, y);
            if (depth_[i] == kNothing) continue;
            float darkness = 0;
            for (const Ring& ring : kRings) {
                float sum = 0;
                for (const auto& d : kDirections) {
                    const int nx = x + d[0] * ring.radius, ny = y + d[1] * ring.radius;
                    if (nx < 0 || ny < 0 || nx >= width_ || ny >= height_) continue;
                    const float nearer = depth_[index(nx, ny)] - depth_[i];
                    // Levelled off: far behind is not darker than behind.
                    if (nearer > 0) sum += nearer / (nearer + unit);
                }
                darkness += ring.strength * sum / 8;
            }
            colour_[i] *= std::exp(-darkness);
        }
    }
}

void Canvas::copyTo(mrpt::img::CImage& image, int left, const Rgb& top,
                    const Rgb& bottom) const {
    for (int y = 0; y < height(); ++y) {
        const float down = static_cast<float>(y) / static_cast<float>(height());
        const Rgb background = top + down * (bottom - top);
        for (int x = 0; x < width(); ++x) {
            Rgb sum = Rgb::Zero();
            for (int sy = 0; sy < kSamples; ++sy)
                for (int sx = 0; sx < kSamples; ++sx) {
                    const auto i = index(x * kSamples + sx, y * kSamples + sy);
                    sum += depth_[i] == kNothing ? background : colour_[i];
                }
            const Rgb c = (sum * (255.0f / (kSamples * kSamples))).min(255.0f).max(0.0f);
            const auto byte = [&c](int channel) {
                return static_cast<std::uint8_t>(std::lround(c[channel]));
            };
            image.setPixel(left + x, y, mrpt::img::TColor(byte(0), byte(1), byte(2)));
        }
    }
}

}  // namespace superray
