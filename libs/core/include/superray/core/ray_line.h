// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file ray_line.h
/// The digital line that a ray is: integers only, so the same cells come out
/// of every walk direction, compiler and instruction set (design rule 2).

#include <superray/core/cell.h>

#include <cstdint>

namespace superray {

/// Fixed point: 2^31 units per cell.
inline constexpr int kUnitBits = 31;
inline constexpr std::int64_t kUnitsPerCell = std::int64_t{1} << kUnitBits;

/// Fixed-point coordinate of a scaled (cell-unit) coordinate: the odd number
/// 2 floor(2^30 s) + 1. Odd, so that no point lies on a cell border; the cell
/// is unchanged: floor(units / 2^31) == floor(s).
inline std::int64_t toUnits(double scaled) {
    return 2 * floorToInt(scaled * 1073741824.0) + 1;
}

/// A point in units.
template <int Dim>
using Units = std::array<std::int64_t, static_cast<std::size_t>(Dim)>;

/// A ray in units, seen along its major axis (the one with the largest
/// extent; the lowest such axis).
///
/// Axes along which the ray runs backwards are mirrored (cell c becomes ~c),
/// so every mirrored coordinate increases. *Slice* k of a ray is the part
/// inside major cell first[major] + k, k = 0 .. slices()-1. On leaving
/// slice k (k < slices()-1) the ray has the coordinates
///
///     atExit(a, k) = exit0[a] + k * slope[a]      (exact integers)
///
/// and crosses the border between cells j and j+1 of axis a at "time"
/// ((j+1) 2^31 - exit0[a]) / slope[a], an exact fraction; the major axis
/// crosses its k-th border at time k. Borders are crossed in order of time;
/// ties: the major axis last, else the higher axis first. Axes that have
/// reached the end cell take no further step, so the walk always ends there
/// after |dx| + |dy| (+ |dz|) steps.
///
/// Slopes are rounded down, so coordinates lag the real segment by less than
/// (slices + 2) * 2^-31 cells and never pass the end cell early.
template <int Dim>
struct RayLine {
    int major = 0;
    Cell<Dim> flip{};    ///< 0, or -1 where mirrored
    Cell<Dim> first{};   ///< mirrored start cell
    Cell<Dim> last{};    ///< mirrored end cell, >= first
    Units<Dim> slope{};  ///< units per slice, 0 .. 2^31
    Units<Dim> exit0{};  ///< units on leaving slice 0

    RayLine() = default;
    /// \param from,to in units (toUnits)
    RayLine(const Units<Dim>& from, const Units<Dim>& to);
    /// \pre geometry.contains(origin) && geometry.contains(end)
    RayLine(const CellGeometry<Dim>& geometry, const Point<Dim>& origin, const Point<Dim>& end)
        : RayLine(unitsOf(geometry, origin), unitsOf(geometry, end)) {}

    static Units<Dim> unitsOf(const CellGeometry<Dim>& g, const Point<Dim>& p) {
        Units<Dim> u;
        for (int a = 0; a < Dim; ++a) u[a] = toUnits(g.scaled(p[a]));
        return u;
    }

    std::int32_t slices() const { return last[major] - first[major] + 1; }
    std::int64_t atExit(int axis, std::int32_t slice) const {
        return exit0[axis] + slice * slope[axis];
    }
    /// Mirrored cell coordinate on entering a slice.
    std::int32_t entryCell(int axis, std::int32_t slice) const {
        if (axis == major) return first[axis] + slice;
        return slice == 0 ? first[axis] : cellOfUnits(atExit(axis, slice - 1));
    }
    /// Mirrored cell coordinate on leaving a slice.
    std::int32_t exitCell(int axis, std::int32_t slice) const {
        if (axis == major) return first[axis] + slice;
        return slice + 1 == slices() ? last[axis] : cellOfUnits(atExit(axis, slice));
    }
    /// Number of steps of the walk = number of free cells of the ray.
    std::int64_t steps() const {
        std::int64_t n = 0;
        for (int a = 0; a < Dim; ++a) n += last[a] - first[a];
        return n;
    }
    Cell<Dim> unmirrored(Cell<Dim> c) const {
        for (int a = 0; a < Dim; ++a) c[a] ^= flip[a];
        return c;
    }
    Cell<Dim> startCell() const { return unmirrored(first); }
    Cell<Dim> endCell() const { return unmirrored(last); }

    /// Units per slice of an axis with this extent, 0 <= extent <= length.
    static std::int64_t slopeOf(std::int64_t extent, std::int64_t length) {
        if (length == 0) return 0;
        // One correctly rounded division and an exact scaling: the same bits
        // everywhere (extents have at most 48 bits).
        return static_cast<std::int64_t>(static_cast<double>(extent) /
                                         static_cast<double>(length) * 2147483648.0);
    }

    static std::int32_t cellOfUnits(std::int64_t units) {
        return static_cast<std::int32_t>(units >> kUnitBits);
    }

    /// True if axis a crosses the border beyond cell ca before axis b crosses
    /// the border beyond cell cb (both not major; exact, ties as above).
    bool crossesBefore(int a, std::int32_t ca, int b, std::int32_t cb) const {
        __extension__ using Wide = __int128;
        const Wide left = Wide{(std::int64_t{ca} + 1) * kUnitsPerCell - exit0[a]} * slope[b];
        const Wide right = Wide{(std::int64_t{cb} + 1) * kUnitsPerCell - exit0[b]} * slope[a];
        return left != right ? left < right : a > b;
    }
};

template <int Dim>
inline RayLine<Dim>::RayLine(const Units<Dim>& from, const Units<Dim>& to) {
    Units<Dim> start, extent;
    for (int a = 0; a < Dim; ++a) {
        const bool backwards = to[a] < from[a];
        flip[a] = backwards ? -1 : 0;
        start[a] = backwards ? -from[a] : from[a];
        extent[a] = backwards ? from[a] - to[a] : to[a] - from[a];
        first[a] = cellOfUnits(start[a]);
        last[a] = cellOfUnits(start[a] + extent[a]);
        if (extent[a] > extent[major]) major = a;
    }
    // Fraction of a slice from the start to the first major border, < 2^31.
    const std::int64_t toBorder =
        (std::int64_t{first[major]} + 1) * kUnitsPerCell - start[major];
    for (int a = 0; a < Dim; ++a) {
        // The major axis advances a whole cell per slice: no division.
        slope[a] = a == major ? (extent[a] > 0 ? kUnitsPerCell : 0)
                              : slopeOf(extent[a], extent[major]);
        exit0[a] = start[a] + ((toBorder * slope[a]) >> kUnitBits);
    }
}

}  // namespace superray
