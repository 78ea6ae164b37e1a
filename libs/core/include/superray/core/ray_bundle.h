#pragma once
/// \file ray_bundle.h
/// A scan as a value: origins and end points in the map frame, cut to range.

#include <superray/core/cell.h>

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
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

/// An array of doubles that grows without being filled with zeros first.
class Coordinates {
 public:
    Coordinates() = default;
    Coordinates(const Coordinates& o);
    Coordinates(Coordinates&&) noexcept = default;
    Coordinates& operator=(Coordinates o) noexcept {
        values_.swap(o.values_);
        std::swap(size_, o.size_);
        std::swap(capacity_, o.capacity_);
        return *this;
    }
    std::size_t size() const { return size_; }
    const double* data() const { return values_.get(); }
    double operator[](std::size_t i) const { return values_[i]; }
    void reserve(std::size_t n);
    bool full() const { return size_ == capacity_; }
    /// \pre !full()
    void push(double v) { values_[size_++] = v; }
    /// Where the next values go, for whoever fills in many. \pre room is reserved
    double* end() { return values_.get() + size_; }
    /// \pre that many values were filled in
    void grow(std::size_t n) { size_ += n; }
    void set(std::size_t i, double v) { values_[i] = v; }
    void clear() { size_ = 0; }

 private:
    std::unique_ptr<double[]> values_;
    std::size_t size_ = 0, capacity_ = 0;
};

/// Rays of one scan. All have one origin unless given per ray (de-skewing).
/// Coordinates are kept axis by axis, as the vector units want them.
template <int Dim>
class RayBundle {
 public:
    /// \param limits applied as points are added
    /// \throws std::invalid_argument if the origin is not addressable or the
    /// limits are not valid
    RayBundle(const CellGeometry<Dim>& geometry, const Point<Dim>& origin,
              const RangeLimits& limits = {});

    /// Begins another scan; keeps the memory. \throws as the constructor, and
    /// leaves the bundle as it was
    void restart(const Point<Dim>& origin);

    /// Adds a ray from the common origin. A bad point is skipped and counted.
    /// A hit beyond the maximum range becomes an open ray cut there.
    void add(const Point<Dim>& end, RayEnd kind = RayEnd::hit) {
        if (!origins_.empty())
            add(origin_, end, kind);
        else if (unlimited_ && geometry_.contains(end))
            push(end, kind);
        else
            addRay(origin_, end, kind);
    }

    /// Adds returns, in order: as add(end) for each, but many times faster.
    /// \param ends coordinates of `count` end points [m, map frame], point by point
    void addReturns(const float* ends, std::size_t count);
    void addReturns(const double* ends, std::size_t count);

    /// Adds a ray with its own origin [m, map frame].
    void add(const Point<Dim>& origin, const Point<Dim>& end, RayEnd kind);

    void reserve(std::size_t n);

    /// Begins a copy of another scan in another order: with its origin, bounds and
    /// number of rays, each of which is to be placed. \pre other.hasCommonOrigin()
    void restartLike(const RayBundle& other);
    /// Ray i becomes a copy of a ray of that scan. Threads may place different rays.
    void place(std::size_t i, const RayBundle& other, std::size_t ray) {
        for (int a = 0; a < Dim; ++a) ends_[a].set(i, other.ends_[a][ray]);
        kinds_[i] = other.kinds_[ray];
    }

    const CellGeometry<Dim>& geometry() const { return geometry_; }
    std::size_t size() const { return kinds_.size(); }
    bool empty() const { return kinds_.empty(); }
    const Point<Dim>& origin(std::size_t i) const {
        return origins_.empty() ? origin_ : origins_[i];
    }
    Point<Dim> end(std::size_t i) const {
        Point<Dim> p;
        for (int a = 0; a < Dim; ++a) p[a] = ends_[a][i];
        return p;
    }
    /// Coordinates of all end points along one axis [m].
    const double* ends(int axis) const { return ends_[axis].data(); }
    RayEnd kind(std::size_t i) const { return kinds_[i]; }
    const RayEnd* kinds() const { return kinds_.data(); }
    /// True if all rays start at commonOrigin().
    bool hasCommonOrigin() const { return origins_.empty(); }
    const Point<Dim>& commonOrigin() const { return origin_; }
    const SkippedPoints& skipped() const { return skipped_; }
    /// Bounds of all origins and end points [m]. \pre !empty()
    const Point<Dim>& lowest() const { return lowest_; }
    const Point<Dim>& highest() const { return highest_; }

 private:
    void addRay(const Point<Dim>& origin, const Point<Dim>& end, RayEnd kind);
    template <typename Scalar>
    void addPoints(const Scalar* ends, std::size_t count);
    void push(const Point<Dim>& end, RayEnd kind) {
        if (ends_[0].full()) reserve(2 * size() + 1024);
        for (int a = 0; a < Dim; ++a) ends_[a].push(end[a]);
        kinds_.push_back(kind);
        include(end);
    }
    void include(const Point<Dim>& p) {
        for (int a = 0; a < Dim; ++a) {
            lowest_[a] = p[a] < lowest_[a] ? p[a] : lowest_[a];
            highest_[a] = p[a] > highest_[a] ? p[a] : highest_[a];
        }
    }

    CellGeometry<Dim> geometry_;
    Point<Dim> origin_, lowest_, highest_;
    RangeLimits limits_;
    bool unlimited_;
    std::array<Coordinates, static_cast<std::size_t>(Dim)> ends_;
    std::vector<RayEnd> kinds_;
    std::vector<Point<Dim>> origins_;  // empty: all start at origin_
    SkippedPoints skipped_;
};

extern template class RayBundle<2>;
extern template class RayBundle<3>;

}  // namespace superray
