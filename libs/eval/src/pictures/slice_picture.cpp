// SPDX-License-Identifier: BSD-3-Clause
#include "pictures/slice_picture.h"

#include <superray/eval/input_error.h>

#include <algorithm>
#include <limits>

namespace superray {
namespace {

using mrpt::img::CImage;
using mrpt::img::TColor;

constexpr int kWidest = 1600, kHighest = 900;  // pixels of a panel
constexpr int kLargestCell = 8;                // pixels
constexpr int kTitle = 22;                     // pixels above a panel, and of the legend

struct Range {
    std::int32_t low = std::numeric_limits<std::int32_t>::max();
    std::int32_t high = std::numeric_limits<std::int32_t>::min();
    void include(std::int32_t i) {
        low = std::min(low, i);
        high = std::max(high, i);
    }
    int size() const { return high - low + 1; }
};

TColor colourOf(CellVerdict verdict) {
    switch (verdict) {
        case CellVerdict::free:
            return {255, 255, 255};
        case CellVerdict::kept:
            return {40, 44, 52};
        case CellVerdict::wrong:
            return {240, 190, 0};
        case CellVerdict::missing:
            return {220, 30, 30};
        default:
            return {205, 208, 212};
    }
}

void drawPanel(CImage& image, int top, const SlicePanel& panel, const Range& x, const Range& y,
               int pixels) {
    // Those that count more are drawn later, over the others.
    std::vector<SliceCell> cells = panel.cells;
    std::stable_sort(cells.begin(), cells.end(),
                     [](const auto& a, const auto& b) { return a.verdict < b.verdict; });
    for (const SliceCell& cell : cells) {
        const int left = (cell.x - x.low) * pixels;
        const int upper = top + (y.high - cell.y) * pixels;
        image.filledRectangle(left, upper, left + pixels - 1, upper + pixels - 1,
                              colourOf(cell.verdict));
    }
}

}  // namespace

CImage drawSlices(const std::vector<SlicePanel>& panels, double edge) {
    Range x, y;
    for (const SlicePanel& panel : panels)
        for (const SliceCell& cell : panel.cells) {
            x.include(cell.x);
            y.include(cell.y);
        }
    if (x.low > x.high) throw InputError("there is nothing to draw: the slice has no cell");
    const int pixels =
        std::clamp(std::min(kWidest / x.size(), kHighest / y.size()), 1, kLargestCell);
    const int width = std::max(x.size() * pixels, 640), height = y.size() * pixels;
    const int total = static_cast<int>(panels.size()) * (height + kTitle) + kTitle;
    CImage image(static_cast<unsigned>(width), static_cast<unsigned>(total), mrpt::img::CH_RGB);
    image.filledRectangle(0, 0, width - 1, total - 1, colourOf(CellVerdict::unknown));
    image.selectTextFont("9x15");
    const TColor black(0, 0, 0);
    int top = 0;
    for (const SlicePanel& panel : panels) {
        image.textOut(4, top + 3, panel.title, black);
        drawPanel(image, top + kTitle, panel, x, y, pixels);
        top += kTitle + height;
    }
    int left = 4;
    for (const auto& [verdict, text] :
         {std::pair(CellVerdict::kept, "kept"), std::pair(CellVerdict::missing, "missing"),
          std::pair(CellVerdict::wrong, "false"), std::pair(CellVerdict::free, "free")}) {
        image.filledRectangle(left, top + 5, left + 11, top + 16, colourOf(verdict));
        image.textOut(left + 16, top + 3, text, black);
        left += 100;
    }
    image.textOut(left, top + 3, std::to_string(x.size() * edge).substr(0, 5) + " m wide",
                  black);
    return image;
}

}  // namespace superray
