#pragma once
// Digital lines of many rays from one origin, axis by axis: set up in vectors.

#include <superray/core/ray_bundle.h>
#include <superray/core/ray_line.h>

namespace superray {

/// The same integers as RayLine has, for up to kSize consecutive rays.
template <int Dim>
struct LineBatch {
    static constexpr std::size_t kSize = 256;
    std::size_t count = 0;
    alignas(64) double end[Dim][kSize];            ///< end points [m]
    /// dominant axis + 4 * (bit a: axis a is mirrored): lines of one kind from
    /// one origin have equal `first` and equal slices.
    alignas(64) std::int32_t kind[kSize];
    alignas(64) std::int32_t last[Dim][kSize];     ///< mirrored end cell
    alignas(64) std::int64_t slope[Dim][kSize];    ///< units per slice
    alignas(64) std::int64_t exit0[Dim][kSize];    ///< units on leaving slice 0
    Units<Dim> origin{};

    int dominant(std::size_t i) const { return kind[i] & 3; }
    std::int32_t flip(std::size_t i, int axis) const { return -(kind[i] >> (2 + axis) & 1); }
    /// Mirrored start cell.
    std::int32_t first(std::size_t i, int axis) const {
        return RayLine<Dim>::cellOfUnits(origin[axis]) ^ flip(i, axis);
    }
    RayLine<Dim> line(std::size_t i) const {
        RayLine<Dim> l;
        l.dominant = dominant(i);
        for (int a = 0; a < Dim; ++a) {
            l.flip[a] = flip(i, a);
            l.first[a] = first(i, a);
            l.last[a] = last[a][i];
            l.slope[a] = slope[a][i];
            l.exit0[a] = exit0[a][i];
        }
        return l;
    }
};

/// Sets up `count` lines from `origin` to `end`.
template <int Dim>
using LineSetUp = void (*)(const CellGeometry<Dim>& geometry, LineBatch<Dim>& lines);

}  // namespace superray
