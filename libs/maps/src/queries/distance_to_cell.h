// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file distance_to_cell.h

#include <superray/core/cell.h>

#include <algorithm>
#include <cmath>

namespace superray {

/// Distance from a point to a cell's box [m], 0 inside.
template <int Dim>
double distanceToCell(const Point<Dim>& p, const Cell<Dim>& cell,
                      const CellGeometry<Dim>& geometry) {
    const Point<Dim> low = geometry.lowerCorner(cell);
    double squared = 0;
    for (int a = 0; a < Dim; ++a) {
        const double gap =
            std::max({0.0, low[a] - p[a], p[a] - low[a] - geometry.resolution()});
        squared += gap * gap;
    }
    return std::sqrt(squared);
}

}  // namespace superray
