// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file cell.h
/// Points, cells, and the one function that maps the former to the latter.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace superray {

/// A point in the map frame [m].
template <int Dim>
using Point = Eigen::Matrix<double, Dim, 1>;

/// Integer cell index per axis; cell i covers [i, i+1) * resolution.
template <int Dim>
using Cell = std::array<std::int32_t, static_cast<std::size_t>(Dim)>;

/// Cells are addressable in [-kCellLimit, kCellLimit) per axis: OctoMap's
/// 16-bit key range, shared by every storage type so that results are equal.
inline constexpr std::int32_t kCellLimit = 32768;

/// Edges that cells may have [m]: far from where what is computed from them overflows.
inline constexpr double kFinestResolution = 1e-6, kCoarsestResolution = 1e6;
inline constexpr const char* kResolutionRule = "from 1e-6 to 1e6 m";

inline bool isResolution(double metres) {
    return metres >= kFinestResolution && metres <= kCoarsestResolution;  // NaN is not
}

/// E.g. "0.1 m": the shortest text that tells the number from all others.
std::string metresText(double metres);

/// floor() to an integer without a library call (x86-64's baseline has no
/// rounding instruction). \pre |x| < 2^62
inline std::int64_t floorToInt(double x) {
    const auto truncated = static_cast<std::int64_t>(x);
    return truncated - (x < static_cast<double>(truncated));
}

/// Grid geometry: a resolution and the cell of a point (design rule 1).
template <int Dim>
class CellGeometry {
 public:
    /// \param resolution cell edge [m]
    /// \throws std::invalid_argument unless isResolution()
    explicit CellGeometry(double resolution);

    double resolution() const { return resolution_; }

    /// Cell coordinate (not yet floored) of a coordinate [m]: the same
    /// multiplication as OctoMap's coordToKey, so the same cell.
    double scaled(double coordinate) const { return coordinate * inverse_; }

    /// True if all coordinates are finite and in the addressable range.
    bool contains(const Point<Dim>& p) const {
        for (int a = 0; a < Dim; ++a) {
            const double s = scaled(p[a]);
            // Written so that NaN fails.
            if (!(s >= -double{kCellLimit} && s < double{kCellLimit})) return false;
        }
        return true;
    }

    /// Cell of a point. \pre contains(p)
    Cell<Dim> cellOf(const Point<Dim>& p) const {
        Cell<Dim> c;
        for (int a = 0; a < Dim; ++a)
            c[a] = static_cast<std::int32_t>(floorToInt(scaled(p[a])));
        return c;
    }

    /// Centre of a cell [m].
    Point<Dim> center(const Cell<Dim>& c) const {
        Point<Dim> p;
        for (int a = 0; a < Dim; ++a) p[a] = (c[a] + 0.5) * resolution_;
        return p;
    }

    /// Corner with the lowest coordinates of a cell [m].
    Point<Dim> lowerCorner(const Cell<Dim>& c) const {
        Point<Dim> p;
        for (int a = 0; a < Dim; ++a) p[a] = c[a] * resolution_;
        return p;
    }

 private:
    double resolution_;
    double inverse_;
};

extern template class CellGeometry<2>;
extern template class CellGeometry<3>;

}  // namespace superray
