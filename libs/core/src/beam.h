#pragma once
// A beam: neighbouring rays of one kind, and bounds of the cells they can visit,
// slice by slice: a superset, exact in the same integers as the rays.

#include "line_batch.h"

#include <algorithm>

namespace superray {

/// Bounds of lines of one kind from one origin. Of two such lines, the one that
/// is steeper on a minor axis is nowhere behind on that axis.
template <int Dim>
struct Beam {
    int dominant;
    Cell<Dim> flip, first;
    Units<Dim> slopeLow, slopeHigh, exitLow, exitHigh;
    std::int32_t slices;  ///< of the longest line

    /// Bounds lines[from, to). \pre from < to; all of one kind
    Beam(const LineBatch<Dim>& lines, std::size_t from, std::size_t to)
        : dominant(lines.dominant(from)) {
        for (int a = 0; a < Dim; ++a) {
            flip[a] = lines.flip(from, a);
            first[a] = lines.first(from, a);
        }
        std::int32_t last = lines.last[dominant][from];
        for (std::size_t i = from; i < to; ++i)
            last = std::max(last, lines.last[dominant][i]);
        slices = last - first[dominant] + 1;
        for (int a = 0; a < Dim; ++a) {
            const auto slope = std::minmax_element(lines.slope[a] + from, lines.slope[a] + to);
            const auto exit = std::minmax_element(lines.exit0[a] + from, lines.exit0[a] + to);
            slopeLow[a] = *slope.first;
            slopeHigh[a] = *slope.second;
            exitLow[a] = *exit.first;
            // In their last slice, lines make up for what rounding down has
            // cost, which is less than this.
            exitHigh[a] = *exit.second + slices + 2;
        }
    }

    /// Mirrored minor cells of slice k: from low() to high().
    std::int32_t low(int axis, std::int32_t k) const {
        return std::max(first[axis], RayLine<Dim>::cellOfUnits(exitLow[axis] +
                                                               (k - 1) * slopeLow[axis]));
    }
    std::int32_t high(int axis, std::int32_t k) const {
        return RayLine<Dim>::cellOfUnits(exitHigh[axis] + k * slopeHigh[axis]);
    }
};

}  // namespace superray
