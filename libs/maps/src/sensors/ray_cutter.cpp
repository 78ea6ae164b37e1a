// SPDX-License-Identifier: BSD-3-Clause
#include "sensors/ray_cutter.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace superray {

using Eigen::Vector3d;

template <int Dim>
RayCutter<Dim>::RayCutter(const TInsertionOptions& options, const CellGeometry<Dim>& geometry,
                          bool clipToBand)
    : geometry_(geometry),
      limits_(options.rangeLimits()),
      low_(options.heightBandMin),
      high_(options.heightBandMax),
      clipToBand_(clipToBand && (std::isfinite(low_) || std::isfinite(high_))),
      clearAtMaximum_(options.clearAtMaxrange && std::isfinite(limits_.maximum)) {}

/// Ends the ray at the maximum range, or in the cell after it, so that the cell of the cut
/// is passed through. A return in the cell of the cut keeps that cell from being cleared.
template <int Dim>
void RayCutter<Dim>::cutToMaximum(RayPart& ray) const {
    const Vector3d whole = ray.to - ray.from;
    const double length = whole.template head<Dim>().norm();
    if (!(length > limits_.maximum)) return;
    const Vector3d end = ray.to;
    double fraction = limits_.maximum / length;
    ray.to = ray.from + whole * fraction;
    ray.kind = RayEnd::noReturn;
    const Point<Dim> cut = ray.to.template head<Dim>();
    if (!clearAtMaximum_ || !geometry_.contains(cut)) return;
    const Cell<Dim> cell = geometry_.cellOf(cut);
    const Point<Dim> endPoint = end.template head<Dim>();
    if (!geometry_.contains(endPoint) || geometry_.cellOf(endPoint) == cell) return;
    // To the nearest border of the cell, and a little beyond it.
    constexpr double kBeyond = 1e-3;  // cells
    const double edge = geometry_.resolution();
    double exit = std::numeric_limits<double>::infinity();
    for (int a = 0; a < Dim; ++a) {
        if (whole[a] == 0) continue;
        const double border =
            whole[a] > 0 ? (cell[a] + 1 + kBeyond) * edge : (cell[a] - kBeyond) * edge;
        exit = std::min(exit, (border - ray.from[a]) / whole[a]);
    }
    fraction = std::min(std::max(exit, fraction), 1.0);
    ray.to = ray.from + whole * fraction;
}

template <int Dim>
bool RayCutter<Dim>::clip(RayPart& ray, TInsertionReport& report) const {
    const double z0 = ray.from.z(), z1 = ray.to.z();
    const bool endsOutside = z1 < low_ || z1 > high_;
    if (endsOutside && ray.kind == RayEnd::hit) {
        ++report.outOfHeightBand;
        ray.kind = RayEnd::noReturn;
    }
    if (std::max(z0, z1) < low_ || std::min(z0, z1) > high_) return false;
    const Vector3d from = ray.from, whole = ray.to - ray.from;
    const auto at = [&](double height) { return from + whole * ((height - z0) / (z1 - z0)); };
    if (z0 < low_) ray.from = at(low_);
    if (z0 > high_) ray.from = at(high_);
    if (z1 < low_) ray.to = at(low_);
    if (z1 > high_) ray.to = at(high_);
    return true;
}

template <int Dim>
std::optional<RayPart> RayCutter<Dim>::cut(const Vector3d& origin, const Vector3d& end,
                                           RayEnd kind, TInsertionReport& report) const {
    RayPart ray{origin, end, kind};
    if (!end.allFinite()) return ray;
    const double squared = (end - origin).template head<Dim>().squaredNorm();
    if (squared < limits_.minimum * limits_.minimum) {
        ++report.skipped.tooNear;
        return std::nullopt;
    }
    cutToMaximum(ray);
    if (clipToBand_ && !clip(ray, report)) return std::nullopt;
    return ray;
}

template class RayCutter<2>;
template class RayCutter<3>;

}  // namespace superray
