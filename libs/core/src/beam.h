#pragma once
// A beam: neighbouring rays of one kind, and bounds of the cells they can visit,
// slice by slice: a superset, in the same integers as the rays.

#include <superray/core/ray_line.h>

#include "ray_directions.h"

#include <algorithm>

namespace superray {

/// Bounds of the directions of some rays of one kind.
template <int Dim>
struct DirectionBounds {
    float length;  ///< of the longest, along the dominant axis [cells]
    float low[Dim - 1], high[Dim - 1];
    float reach[Dim - 1];  ///< largest extent along the minor axes [cells]

    void include(const DirectionBounds& o) {
        length = std::max(length, o.length);
        for (int m = 0; m < Dim - 1; ++m) {
            low[m] = std::min(low[m], o.low[m]);
            high[m] = std::max(high[m], o.high[m]);
            reach[m] = std::max(reach[m], o.reach[m]);
        }
    }
};

/// What all lines of a kind from one origin have in common.
template <int Dim>
struct BeamStart {
    int dominant = 0;
    Cell<Dim> flip{}, first{};
    Units<Dim> start{};  ///< mirrored origin
    std::int64_t toBorder = 0;
    double within = 0;  ///< cells from the border behind the origin, dominant axis

    BeamStart() = default;
    /// \param origin of the rays [units]
    BeamStart(std::uint32_t kind, const Units<Dim>& origin)
        : dominant(static_cast<int>(kind & 3)) {
        for (int a = 0; a < Dim; ++a) {
            flip[a] = -static_cast<std::int32_t>(kind >> (2 + a) & 1);
            start[a] = flip[a] ? -origin[a] : origin[a];
            first[a] = RayLine<Dim>::cellOfUnits(start[a]);
        }
        toBorder = (std::int64_t{first[dominant]} + 1) * kUnitsPerCell - start[dominant];
        within = static_cast<double>(kUnitsPerCell - toBorder) /
                 static_cast<double>(kUnitsPerCell);
    }
};

/// Bounds of lines of one kind from one origin. Of two such lines, the one that
/// is steeper on a minor axis is nowhere behind on that axis.
template <int Dim>
struct Beam {
    const BeamStart<Dim>& common;
    Units<Dim> slopeLow, slopeHigh, exitLow, exitHigh;
    Cell<Dim> highest;    ///< minor axes: no line goes beyond (mirrored)
    std::int32_t slices;  ///< of the longest line, or one more

    Beam(const DirectionBounds<Dim>& rays, const BeamStart<Dim>& beamStart)
        : common(beamStart) {
        constexpr double kMargin = RayDirections<Dim>::kSlopeMargin;
        const double length = static_cast<double>(rays.length);
        slices = static_cast<std::int32_t>(common.within + length * (1 + kMargin) + kMargin) + 1;
        for (int a = 0, m = 0; a < Dim; ++a) {
            double low = 1, high = 1;
            if (a != common.dominant) {
                low = std::max(0.0, static_cast<double>(rays.low[m]) - kMargin);
                high = std::min(1.0, static_cast<double>(rays.high[m]) + kMargin);
                const double reach = static_cast<double>(rays.reach[m]) + 2 * kMargin * (length + 1);
                highest[a] = RayLine<Dim>::cellOfUnits(
                    common.start[a] + static_cast<std::int64_t>(reach * kUnitsPerCell));
                ++m;
            }
            slopeLow[a] = static_cast<std::int64_t>(low * kUnitsPerCell);
            slopeHigh[a] = static_cast<std::int64_t>(high * kUnitsPerCell);
            exitLow[a] = common.start[a] + ((common.toBorder * slopeLow[a]) >> kUnitBits);
            // In their last slice, lines make up for what rounding down has
            // cost, which is less than this.
            exitHigh[a] = common.start[a] + ((common.toBorder * slopeHigh[a]) >> kUnitBits) +
                          slices + 2;
        }
    }

    /// Mirrored minor cells of slice k: from low() to high().
    std::int32_t low(int axis, std::int32_t k) const {
        return std::max(common.first[axis],
                        RayLine<Dim>::cellOfUnits(exitLow[axis] + (k - 1) * slopeLow[axis]));
    }
    std::int32_t high(int axis, std::int32_t k) const {
        return std::min(highest[axis],
                        RayLine<Dim>::cellOfUnits(exitHigh[axis] + k * slopeHigh[axis]));
    }
};

}  // namespace superray
