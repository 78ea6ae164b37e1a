#pragma once
/// \file ray_bundle.h
/// A scan as a value: origins and end points in the map frame, cut to range.

#include <superray/core/cell.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace superray {

/// What the far end of a ray means.
enum class RayEnd : std::uint8_t {
    hit,  ///< a return: the end cell is hit, the cells before it are free
    open  ///< no return, or cut at maximum range: cells before the end cell are
          ///< free, the end cell itself is left alone (OctoMap's convention)
};

/// Points of a scan that did not become rays, and why.
struct SkippedPoints {
    std::uint64_t notFinite = 0;   ///< NaN or Inf coordinate
    std::uint64_t outOfRange = 0;  ///< outside the addressable cells (kCellLimit)
    std::uint64_t tooNear = 0;     ///< closer than the minimum range
    std::uint64_t total() const { return notFinite + outOfRange + tooNear; }
    SkippedPoints& operator+=(const SkippedPoints& o) {
        notFinite += o.notFinite;
        outOfRange += o.outOfRange;
        tooNear += o.tooNear;
        return *this;
    }
};

/// Limits on the distance from ray origin to end point [m].
struct RangeLimits {
    double minimum = 0;  ///< nearer returns are skipped (and counted)
    double maximum =
        std::numeric_limits<double>::infinity();  ///< farther ones become open rays
    /// \throws std::invalid_argument unless 0 <= minimum < maximum
    void validate() const;
};

/// Rays of one scan. All have one origin unless given per ray (de-skewing).
template <int Dim>
class RayBundle {
 public:
    /// \param limits applied as points are added
    /// \throws std::invalid_argument if the origin is not addressable or the
    /// limits are not valid
    RayBundle(const CellGeometry<Dim>& geometry, const Point<Dim>& origin,
              const RangeLimits& limits = {});

    /// Adds a ray from the common origin. A bad point is skipped and counted.
    /// A hit beyond the maximum range becomes an open ray cut there.
    void add(const Point<Dim>& end, RayEnd kind = RayEnd::hit) { addRay(origin_, end, kind); }

    /// Adds a ray with its own origin [m, map frame].
    void add(const Point<Dim>& origin, const Point<Dim>& end, RayEnd kind);

    void reserve(std::size_t n);

    const CellGeometry<Dim>& geometry() const { return geometry_; }
    std::size_t size() const { return ends_.size(); }
    bool empty() const { return ends_.empty(); }
    const Point<Dim>& origin(std::size_t i) const {
        return origins_.empty() ? origin_ : origins_[i];
    }
    const Point<Dim>& end(std::size_t i) const { return ends_[i]; }
    RayEnd kind(std::size_t i) const { return kinds_[i]; }
    /// True if all rays start at commonOrigin().
    bool hasCommonOrigin() const { return origins_.empty(); }
    const Point<Dim>& commonOrigin() const { return origin_; }
    const SkippedPoints& skipped() const { return skipped_; }

 private:
    void addRay(const Point<Dim>& origin, const Point<Dim>& end, RayEnd kind);

    CellGeometry<Dim> geometry_;
    Point<Dim> origin_;
    RangeLimits limits_;
    std::vector<Point<Dim>> ends_;
    std::vector<RayEnd> kinds_;
    std::vector<Point<Dim>> origins_;  // empty: all start at origin_
    SkippedPoints skipped_;
};

extern template class RayBundle<2>;
extern template class RayBundle<3>;

}  // namespace superray
