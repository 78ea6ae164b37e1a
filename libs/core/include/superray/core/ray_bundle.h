// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file ray_bundle.h
/// A scan as a value: origins and end points in the map frame, cut to range.

#include <superray/core/cell.h>

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace superray {

/// What the far end of a ray means.
enum class RayEnd : std::uint8_t {
    hit,      ///< a return: the end cell is hit, the cells before it are free
    noReturn  ///< nothing seen, or cut at maximum range: the cells before the end cell
              ///< are free, the end cell itself is left alone (OctoMap's convention)
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
        std::numeric_limits<double>::infinity();  ///< farther ones become no-return rays
    /// \throws std::invalid_argument unless 0 <= minimum < maximum
    void validate() const;
};

/// An array of numbers that grows without being filled with zeros first.
template <typename Scalar>
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
    std::size_t capacity() const { return capacity_; }
    const Scalar* data() const { return values_.get(); }
    Scalar operator[](std::size_t i) const { return values_[i]; }
    void reserve(std::size_t n);
    bool full() const { return size_ == capacity_; }
    /// \pre !full()
    void push(Scalar v) { values_[size_++] = v; }
    /// Where the next values go, for whoever fills in many. \pre room is reserved
    Scalar* end() { return values_.get() + size_; }
    /// \pre that many values were filled in
    void grow(std::size_t n) { size_ += n; }
    void set(std::size_t i, Scalar v) { values_[i] = v; }
    void clear() { size_ = 0; }

 private:
    std::unique_ptr<Scalar[]> values_;
    std::size_t size_ = 0, capacity_ = 0;
};

extern template class Coordinates<float>;
extern template class Coordinates<double>;

/// Rays of one scan. All have one origin unless given per ray (de-skewing).
/// Coordinates are kept axis by axis, as the vector units want them: in single
/// precision as long as that holds all of them exactly, which saves half of the memory
/// to go through, then in double precision.
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
    /// A hit beyond the maximum range becomes a no-return ray cut there.
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
    /// \param threads at most so many; the result does not depend on it
    void addReturns(const float* ends, std::size_t count, unsigned threads = 1);
    void addReturns(const double* ends, std::size_t count, unsigned threads = 1);

    /// Adds a ray with its own origin [m, map frame].
    void add(const Point<Dim>& origin, const Point<Dim>& end, RayEnd kind);

    void reserve(std::size_t n);

    /// Begins a copy of another scan in another order: with its origin, bounds and
    /// number of rays, each of which is to be placed. \pre other.hasCommonOrigin()
    void restartLike(const RayBundle& other);
    /// Ray i becomes a copy of a ray of that scan. Threads may place different rays.
    void place(std::size_t i, const RayBundle& other, std::size_t ray) {
        for (int a = 0; a < Dim; ++a) {
            if (single_)
                singles_[a].set(i, other.singles_[a][ray]);
            else
                doubles_[a].set(i, other.doubles_[a][ray]);
        }
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
        for (int a = 0; a < Dim; ++a) p[a] = single_ ? double{singles_[a][i]} : doubles_[a][i];
        return p;
    }
    /// Whether coordinates are kept in single precision.
    bool singlePrecision() const { return single_; }
    /// Coordinates of all end points along one axis [m].
    /// \pre Scalar is float if singlePrecision(), else double
    template <typename Scalar>
    const Scalar* ends(int axis) const {
        return coordinates<Scalar>()[axis].data();
    }
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
    template <typename Scalar>
    using PerAxis = std::array<Coordinates<Scalar>, static_cast<std::size_t>(Dim)>;
    template <typename Scalar>
    const PerAxis<Scalar>& coordinates() const {
        if constexpr (std::is_same_v<Scalar, float>)
            return singles_;
        else
            return doubles_;
    }
    template <typename Scalar>
    PerAxis<Scalar>& coordinates() {
        return const_cast<PerAxis<Scalar>&>(
            std::as_const(*this).template coordinates<Scalar>());
    }
    /// Calls visit(coordinates) with those that are used.
    template <typename Visit>
    void visitKept(const Visit& visit) {
        if (single_)
            visit(singles_);
        else
            visit(doubles_);
    }
    void addRay(const Point<Dim>& origin, const Point<Dim>& end, RayEnd kind);
    void useDoubles();
    template <typename Scalar>
    bool addGoodReturns(const Scalar* ends, std::size_t count, unsigned threads);
    template <typename Scalar>
    void addPoints(const Scalar* ends, std::size_t count, unsigned threads);
    void push(const Point<Dim>& end, RayEnd kind) {
        if (single_ && end != end.template cast<float>().template cast<double>()) useDoubles();
        if (single_ ? singles_[0].full() : doubles_[0].full()) reserve(2 * size() + 1024);
        for (int a = 0; a < Dim; ++a) {
            if (single_)
                singles_[a].push(static_cast<float>(end[a]));
            else
                doubles_[a].push(end[a]);
        }
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
    bool single_ = true;  // which of the following is used
    PerAxis<float> singles_;
    PerAxis<double> doubles_;
    std::vector<RayEnd> kinds_;
    std::vector<Point<Dim>> origins_;  // empty: all start at origin_
    SkippedPoints skipped_;
};

extern template class RayBundle<2>;
extern template class RayBundle<3>;

}  // namespace superray
