#pragma once
// A beam: neighbouring rays of one kind, and bounds of the cells they can visit,
// slice by slice: a superset, in the same integers as the rays.

#include <superray/core/ray_line.h>

#include "ray_directions.h"

#include <algorithm>

namespace superray {

/// Rays order[begin, end) of a scan, of one kind, and bounds of their directions.
template <int Dim>
struct BeamRays {
    std::uint32_t begin, end;
    std::uint32_t kind;
    float length;  ///< of the longest [cells]
    float low[Dim - 1], high[Dim - 1];
    std::int32_t slice = 0;  ///< before this one, no miss matters any more
};

/// Bounds of lines of one kind from one origin. Of two such lines, the one that
/// is steeper on a minor axis is nowhere behind on that axis.
template <int Dim>
struct Beam {
    int dominant;
    Cell<Dim> flip, first;
    Units<Dim> slopeLow, slopeHigh, exitLow, exitHigh;
    std::int32_t slices;  ///< of the longest line, or one more

    /// \param origin of the rays [units]
    Beam(const BeamRays<Dim>& rays, const Units<Dim>& origin) {
        constexpr double kMargin = RayDirections<Dim>::kSlopeMargin;
        dominant = static_cast<int>(rays.kind & 3);
        Units<Dim> start;
        for (int a = 0; a < Dim; ++a) {
            flip[a] = -static_cast<std::int32_t>(rays.kind >> (2 + a) & 1);
            start[a] = flip[a] ? -origin[a] : origin[a];
            first[a] = RayLine<Dim>::cellOfUnits(start[a]);
        }
        const double within = static_cast<double>(start[dominant] & (kUnitsPerCell - 1)) /
                              static_cast<double>(kUnitsPerCell);
        slices = static_cast<std::int32_t>(within + rays.length * (1 + kMargin) + kMargin) + 1;
        const std::int64_t toBorder =
            (std::int64_t{first[dominant]} + 1) * kUnitsPerCell - start[dominant];
        for (int a = 0, m = 0; a < Dim; ++a) {
            double low = 1, high = 1;
            if (a != dominant) {
                low = std::max(0.0, rays.low[m] - kMargin);
                high = std::min(1.0, rays.high[m] + kMargin);
                ++m;
            }
            slopeLow[a] = static_cast<std::int64_t>(low * kUnitsPerCell);
            slopeHigh[a] = static_cast<std::int64_t>(high * kUnitsPerCell);
            exitLow[a] = start[a] + ((toBorder * slopeLow[a]) >> kUnitBits);
            // In their last slice, lines make up for what rounding down has
            // cost, which is less than this.
            exitHigh[a] = start[a] + ((toBorder * slopeHigh[a]) >> kUnitBits) + slices + 2;
        }
    }

    /// Mirrored minor cells of slice k: from low() to high().
    std::int32_t low(int axis, std::int32_t k) const {
        return std::max(first[axis],
                        RayLine<Dim>::cellOfUnits(exitLow[axis] + (k - 1) * slopeLow[axis]));
    }
    std::int32_t high(int axis, std::int32_t k) const {
        return RayLine<Dim>::cellOfUnits(exitHigh[axis] + k * slopeHigh[axis]);
    }
};

}  // namespace superray
