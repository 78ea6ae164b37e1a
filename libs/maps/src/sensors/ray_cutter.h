// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file ray_cutter.h
/// The part of a ray that a map takes: within the range limits, and in 2D within the
/// height band.

#include <superray/core/cell.h>
#include <superray/core/ray_bundle.h>
#include <superray/maps/insertion_report.h>
#include <superray/maps/options.h>

#include <Eigen/Core>
#include <optional>

namespace superray {

/// What is left of a ray [m, map frame].
struct RayPart {
    Eigen::Vector3d from, to;
    RayEnd kind;
};

/// Cuts rays where RayBundle alone cannot: see TInsertionOptions::heightBandMin and
/// clearAtMaxrange. Its results are to be added to a bundle without limits.
template <int Dim>
class RayCutter {
 public:
    /// \param clipToBand 3D sensors in 2D maps: keep what lies inside the height band.
    ///        Otherwise the band is not looked at.
    RayCutter(const TInsertionOptions& options, const CellGeometry<Dim>& geometry,
              bool clipToBand);

    /// False if a bundle with limits does the same, only faster.
    bool isNeeded() const { return clipToBand_ || clearAtMaximum_; }

    /// \param report counts what is left out, and returns outside the height band
    /// \return nothing if nothing is left; points that are not finite are passed on, for
    ///         the bundle to count
    std::optional<RayPart> cut(const Eigen::Vector3d& origin, const Eigen::Vector3d& end,
                               RayEnd kind, TInsertionReport& report) const;

 private:
    void cutToMaximum(RayPart& ray) const;
    /// \return false if nothing is left
    bool clip(RayPart& ray, TInsertionReport& report) const;

    CellGeometry<Dim> geometry_;
    RangeLimits limits_;
    double low_, high_;
    bool clipToBand_, clearAtMaximum_;
};

extern template class RayCutter<2>;
extern template class RayCutter<3>;

}  // namespace superray
