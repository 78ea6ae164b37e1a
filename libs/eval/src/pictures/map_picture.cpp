// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/map_picture.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "pictures/canvas.h"

namespace superray {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;
using mrpt::img::CImage;
using mrpt::img::TColor;

const Rgb kBackgroundTop(0.13f, 0.15f, 0.19f), kBackgroundBottom(0.05f, 0.06f, 0.08f);
constexpr float kPi = 3.14159265f;

/// Colours from low to high, of rising lightness so that they read in grey too.
Rgb heightColour(float fraction) {
    static const std::array<Rgb, 6> kStops = {
        Rgb(0.29f, 0.22f, 0.62f), Rgb(0.16f, 0.44f, 0.80f), Rgb(0.13f, 0.67f, 0.68f),
        Rgb(0.45f, 0.80f, 0.40f), Rgb(0.93f, 0.82f, 0.30f), Rgb(0.99f, 0.60f, 0.30f)};
    const float at = std::clamp(fraction, 0.0f, 1.0f) * static_cast<float>(kStops.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
    return kStops[i] + (at - static_cast<float>(i)) * (kStops[i + 1] - kStops[i]);
}

struct Interval {
    float low = 0, high = 0;
    float length() const { return high - low; }
    float center() const { return 0.5f * (low + high); }
};

/// The interval without the outermost `share` of the values on either side.
Interval mostOf(std::vector<float> values, double share) {
    const auto last = static_cast<double>(values.size() - 1);
    const auto at = [&](double fraction) {
        const auto nth = values.begin() + static_cast<std::ptrdiff_t>(fraction * last);
        std::nth_element(values.begin(), nth, values.end());
        return *nth;
    };
    return {at(share), at(1 - share)};
}

/// Cells with a flag each, by block.
class CellSet {
 public:
    void insert(const BlockKey<3>& key, const BlockMask<3>& cells) {
        if (cells.any()) blocks_[key] = cells;
    }
    bool has(const Cell<3>& cell) const {
        const auto block = blocks_.find(blockOf<3>(cell));
        return block != blocks_.end() && block->second.test(indexInBlock<3>(cell));
    }
    template <class Visit>
    void forEach(const Visit& visit) const {
        for (const auto& [key, mask] : blocks_)
            for (int i = 0; i < kBlockCells<3>; ++i)
                if (mask.test(i)) visit(cellInBlock<3>(key, i));
    }

 private:
    std::unordered_map<BlockKey<3>, BlockMask<3>, IndexHash> blocks_;
};

/// Orthographic camera; lengths in cells.
struct View {
    Vector3f right, up, toViewer;
    float scale = 1;       ///< pixels per cell
    Vector2f shift{0, 0};  ///< [pixels]

    Vector3f project(const Vector3f& p) const {
        return {scale * p.dot(right) + shift.x(), -scale * p.dot(up) + shift.y(),
                p.dot(toViewer)};
    }
    Vector3f projectDirection(const Vector3f& d) const {
        return {scale * d.dot(right), -scale * d.dot(up), d.dot(toViewer)};
    }

    /// From a direction [rad]: azimuth of the viewer, elevation above the plane.
    static View from(float azimuth, float elevation) {
        const float ca = std::cos(azimuth), sa = std::sin(azimuth);
        const float ce = std::cos(elevation), se = std::sin(elevation);
        View v;
        v.right = {-sa, ca, 0};
        v.up = {-se * ca, -se * sa, ce};
        v.toViewer = {ce * ca, ce * sa, se};
        return v;
    }

    /// Scales and centres so that nearly all points are in the picture.
    void frame(const std::vector<Vector3f>& points, int width, int height) {
        std::vector<float> x, y;
        for (const auto& p : points) {
            x.push_back(p.dot(right));
            y.push_back(p.dot(up));
        }
        const Interval ix = mostOf(std::move(x), 0.01), iy = mostOf(std::move(y), 0.01);
        constexpr float kFilled = 0.86f;
        const auto w = static_cast<float>(width), h = static_cast<float>(height);
        scale = kFilled * std::min(w / (ix.length() + 2), h / (iy.length() + 2));
        shift = {0.5f * w - scale * ix.center(), 0.5f * h + scale * iy.center()};
    }
};

struct Scene {
    CellSet cells;
    std::vector<Vector3f> centers;  // [cells]
    Vector2f center{0, 0};          // mean, horizontal [cells]
    Interval heights;               // [cells]
    float resolution = 1;           // [m]
};

Vector3f lowerCorner(const Cell<3>& c) {
    return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
}

/// Draws the faces of a cell that the viewer sees and no other cell covers.
void drawCube(const Scene& scene, const Cell<3>& cell, const View& view, Canvas& canvas) {
    // Light from above, so that the three directions differ.
    constexpr float kLight[3] = {0.80f, 0.64f, 1.0f};
    // Cells smaller than this would hardly be seen.
    constexpr float kLeastPixels = 1.6f;
    const float size = std::max(1.0f, kLeastPixels / view.scale);
    const float height = static_cast<float>(cell[2]) + 0.5f;
    const Rgb colour =
        heightColour((height - scene.heights.low) / std::max(1.0f, scene.heights.length()));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float facing = view.toViewer[static_cast<int>(axis)];
        if (std::abs(facing) < 1e-6f) continue;
        Cell<3> neighbour = cell;
        neighbour[axis] += facing > 0 ? 1 : -1;
        if (scene.cells.has(neighbour)) continue;
        Vector3f corner = lowerCorner(cell) + Vector3f::Constant(0.5f * (1 - size));
        if (facing > 0) corner[static_cast<int>(axis)] += size;
        const auto edge = [&](std::size_t i) {
            return view.projectDirection(size *
                                         Vector3f::Unit(static_cast<int>((axis + i) % 3)));
        };
        canvas.fill({view.project(corner), edge(1), edge(2), colour * kLight[axis]});
    }
}

void drawPanel(const Scene& scene, const View& view, CImage& image, int left, int width) {
    Canvas canvas(width, static_cast<int>(image.getHeight()));
    scene.cells.forEach([&](const Cell<3>& cell) { drawCube(scene, cell, view, canvas); });
    canvas.shadeByDepth(std::max({3.0f, 0.03f * scene.heights.length(), 8 / view.scale}));
    canvas.copyTo(image, left, kBackgroundTop, kBackgroundBottom);
}

std::string inMetres(double metres) {
    char text[32];
    std::snprintf(text, sizeof text, "%g m", metres);
    return text;
}

/// A bar of a round length, about a sixth of the panel.
void drawScaleBar(CImage& image, int left, int width, double pixelsPerMetre,
                  const TColor& colour) {
    const double target = width / 6.0 / pixelsPerMetre;
    double length = std::pow(10.0, std::floor(std::log10(target)));
    if (length * 5 <= target)
        length *= 5;
    else if (length * 2 <= target)
        length *= 2;
    const int x = left + 24, y = static_cast<int>(image.getHeight()) - 24;
    const int end = x + static_cast<int>(std::lround(length * pixelsPerMetre));
    image.filledRectangle(x, y, end, y + 3, colour);
    image.selectTextFont("9x15");
    image.textOut(x, y - 20, inMetres(length), colour);
}

void drawHeightLegend(CImage& image, const Scene& scene) {
    const int x = 24, top = 44, length = std::min(220, static_cast<int>(image.getHeight()) / 3);
    for (int i = 0; i < length; ++i) {
        const Rgb c =
            255.0f * heightColour(1 - static_cast<float>(i) / static_cast<float>(length));
        const auto byte = [&c](int k) { return static_cast<std::uint8_t>(c[k]); };
        image.filledRectangle(x, top + i, x + 12, top + i, TColor(byte(0), byte(1), byte(2)));
    }
    const auto height = [&](float cells) {
        char text[32];
        std::snprintf(text, sizeof text, "%.1f m",
                      static_cast<double>(cells * scene.resolution));
        return std::string(text);
    };
    image.selectTextFont("9x15");
    const TColor white(230, 232, 236);
    image.textOut(x + 20, top - 6, height(scene.heights.high), white);
    image.textOut(x + 20, top + length - 10, height(scene.heights.low), white);
    image.textOut(x, top - 30, "height", white);
}

/// Direction of the longest horizontal extent [rad].
float mainDirection(const Scene& scene) {
    double xx = 0, xy = 0, yy = 0;
    for (const auto& p : scene.centers) {
        const Eigen::Vector2d d = (p.head<2>() - scene.center).cast<double>();
        xx += d.x() * d.x();
        xy += d.x() * d.y();
        yy += d.y() * d.y();
    }
    return static_cast<float>(0.5 * std::atan2(2 * xy, xx - yy));
}

/// Azimuth [rad] from which what is high stands behind what is low, of those
/// that show the longest extent across the picture.
float bestAzimuth(const Scene& scene, float along) {
    float best = 0;
    double lowest = std::numeric_limits<double>::infinity();
    for (const float offset : {-0.36f, 0.36f, 0.64f, -0.64f}) {
        const float azimuth = along + offset * kPi;
        const Vector2f towards(std::cos(azimuth), std::sin(azimuth));
        double highInFront = 0;
        for (const auto& p : scene.centers)
            highInFront += double{p.z() - scene.heights.center()} *
                           double{p.head<2>().dot(towards) - scene.center.dot(towards)};
        if (highInFront < lowest) {
            lowest = highInFront;
            best = azimuth;
        }
    }
    return best;
}

/// The cells to draw.
Scene makeScene(const OccupancyMap<3>& map, const SensorModel& model, double cutAbove) {
    Scene scene;
    scene.resolution = static_cast<float>(map.geometry().resolution());
    map.forEachBlock([&](const BlockView<3>& block) {
        BlockMask<3> drawn;
        for (int i = 0; i < kBlockCells<3>; ++i) {
            const auto cell = cellInBlock<3>(block.key, i);
            if (block.known.test(i) && block.values[i] >= model.occupied() &&
                map.geometry().center(cell).z() <= cutAbove)
                drawn.set(i);
        }
        scene.cells.insert(block.key, drawn);
    });
    std::vector<float> heights;
    scene.cells.forEach([&](const Cell<3>& cell) {
        scene.centers.push_back(lowerCorner(cell) + Vector3f::Constant(0.5f));
        heights.push_back(scene.centers.back().z());
    });
    if (heights.empty())
        throw std::invalid_argument(
            "there is nothing to draw: the map has no occupied cell" +
            std::string(std::isfinite(cutAbove) ? " below the cut" : ""));
    scene.heights = mostOf(std::move(heights), 0.01);
    Eigen::Vector2d sum(0, 0);
    for (const auto& p : scene.centers) sum += p.head<2>().cast<double>();
    scene.center = (sum / static_cast<double>(scene.centers.size())).cast<float>();
    return scene;
}

void validate(const PictureOptions& options) {
    for (const int side : {options.width, options.height})
        if (side < 200 || side > 10000)
            throw std::invalid_argument("picture of " + std::to_string(options.width) + " x " +
                                        std::to_string(options.height) +
                                        " pixels: each side must be in [200, 10000]");
}

}  // namespace

CImage drawMap(const OccupancyMap<3>& map, const SensorModel& model,
               const PictureOptions& options) {
    validate(options);
    const Scene scene = makeScene(map, model, options.cutAbove);
    CImage image(static_cast<unsigned>(options.width), static_cast<unsigned>(options.height),
                 mrpt::img::CH_RGB);
    const float along = mainDirection(scene);
    const int obliqueWidth = options.width * 2 / 3, legendWidth = 80;
    View oblique = View::from(bestAzimuth(scene, along), kPi * 0.20f);
    oblique.frame(scene.centers, obliqueWidth - legendWidth, options.height);
    oblique.shift.x() += static_cast<float>(legendWidth);
    drawPanel(scene, oblique, image, 0, obliqueWidth);

    // The longest extent runs up the narrow panel.
    const int planWidth = options.width - obliqueWidth;
    View plan = View::from(along + kPi, kPi / 2);
    plan.frame(scene.centers, planWidth, options.height);
    drawPanel(scene, plan, image, obliqueWidth, planWidth);

    const TColor white(230, 232, 236);
    const auto perMetre = [&](const View& v) {
        return static_cast<double>(v.scale / scene.resolution);
    };
    drawScaleBar(image, 0, obliqueWidth, perMetre(oblique), white);
    drawScaleBar(image, obliqueWidth, planWidth, perMetre(plan), white);
    drawHeightLegend(image, scene);
    image.filledRectangle(obliqueWidth, 0, obliqueWidth, options.height - 1,
                          TColor(60, 66, 78));
    return image;
}

}  // namespace superray
