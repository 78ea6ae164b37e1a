// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file slice_picture.h
/// Maps over the truth, seen from above: what is missing, and what is false.

#include <mrpt/img/CImage.h>

#include <cstdint>
#include <string>
#include <vector>

namespace superray {

/// What a map makes of a cell; of cells above each other the largest is drawn.
enum class CellVerdict : std::uint8_t {
    unknown,  ///< the map does not know it, and no surface was seen
    free,
    kept,    ///< occupied, as it is
    wrong,   ///< occupied, but nothing is there
    missing  ///< a surface was seen, but the map does not say occupied
};

struct SliceCell {
    std::int32_t x, y;  ///< cell indices
    CellVerdict verdict;
};

/// One map.
struct SlicePanel {
    std::string title;
    std::vector<SliceCell> cells;
};

/// Panels one above the other, all of the same part of the world, with a legend.
/// \param edge of a cell [m]
/// \throws InputError if there is no cell to draw
mrpt::img::CImage drawSlices(const std::vector<SlicePanel>& panels, double edge);

}  // namespace superray
