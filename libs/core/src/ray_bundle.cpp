#include <superray/core/ray_bundle.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "walk_kernel.h"

namespace superray {

void RangeLimits::validate() const {
    if (minimum >= 0 && minimum < maximum) return;
    std::ostringstream message;
    message << "range limits minimum = " << minimum << " m, maximum = " << maximum
            << " m: must satisfy 0 <= minimum < maximum";
    throw std::invalid_argument(message.str());
}

Coordinates::Coordinates(const Coordinates& o) {
    reserve(o.size_);
    std::copy_n(o.values_.get(), o.size_, values_.get());
    size_ = o.size_;
}

void Coordinates::reserve(std::size_t n) {
    if (n <= capacity_) return;
    std::unique_ptr<double[]> larger(new double[n]);
    std::copy_n(values_.get(), size_, larger.get());
    values_ = std::move(larger);
    capacity_ = n;
}

template <int Dim>
RayBundle<Dim>::RayBundle(const CellGeometry<Dim>& geometry, const Point<Dim>& origin,
                          const RangeLimits& limits)
    : geometry_(geometry), limits_(limits) {
    limits_.validate();
    unlimited_ = limits_.minimum == 0 && std::isinf(limits_.maximum);
    restart(origin);
}

template <int Dim>
void RayBundle<Dim>::restart(const Point<Dim>& origin) {
    if (!geometry_.contains(origin)) {
        std::ostringstream message;
        message << "sensor origin (" << origin.transpose()
                << ") m: must be finite and within +-" << kCellLimit * geometry_.resolution()
                << " m (" << kCellLimit << " cells of " << geometry_.resolution() << " m)";
        throw std::invalid_argument(message.str());
    }
    origin_ = lowest_ = highest_ = origin;
    for (Coordinates& c : ends_) c.clear();
    kinds_.clear();
    origins_.clear();
    skipped_ = {};
}

template <int Dim>
void RayBundle<Dim>::reserve(std::size_t n) {
    for (Coordinates& c : ends_) c.reserve(n);
    kinds_.reserve(n);
}

template <int Dim>
void RayBundle<Dim>::restartLike(const RayBundle& other) {
    geometry_ = other.geometry_;
    restart(other.origin_);
    lowest_ = other.lowest_;
    highest_ = other.highest_;
    reserve(other.size());
    for (Coordinates& c : ends_) c.grow(other.size());
    kinds_.resize(other.size());
}

template <int Dim>
template <typename Scalar>
void RayBundle<Dim>::addPoints(const Scalar* ends, std::size_t count) {
    static const CopyPoints<Dim, Scalar> copyPoints = bestKernels<Dim>().copy(Scalar{});
    // Where all points of a batch are good, which is the rule, they are copied as
    // they are; else they are taken one by one.
    constexpr std::size_t kBatch = 512;
    reserve(size() + count);
    for (std::size_t first = 0; first < count; first += kBatch) {
        const std::size_t n = std::min(kBatch, count - first);
        const Scalar* const batch = ends + first * Dim;
        PointBatch<Dim> to;
        for (int a = 0; a < Dim; ++a) to.coordinates[a] = ends_[a].end();
        to.lowest = lowest_;
        to.highest = highest_;
        if (unlimited_ && origins_.empty() && copyPoints(batch, n, geometry_.scaled(1.0), to)) {
            for (Coordinates& c : ends_) c.grow(n);
            kinds_.resize(kinds_.size() + n, RayEnd::hit);
            lowest_ = to.lowest;
            highest_ = to.highest;
            continue;
        }
        for (std::size_t i = 0; i < n; ++i) {
            Point<Dim> p;
            for (int a = 0; a < Dim; ++a) p[a] = static_cast<double>(batch[i * Dim + a]);
            add(p);
        }
    }
}

template <int Dim>
void RayBundle<Dim>::addReturns(const float* ends, std::size_t count) {
    addPoints(ends, count);
}
template <int Dim>
void RayBundle<Dim>::addReturns(const double* ends, std::size_t count) {
    addPoints(ends, count);
}

template <int Dim>
void RayBundle<Dim>::add(const Point<Dim>& origin, const Point<Dim>& end, RayEnd kind) {
    if (!geometry_.contains(origin)) {
        ++(origin.allFinite() ? skipped_.outOfRange : skipped_.notFinite);
        return;
    }
    if (origins_.empty() && origin != origin_) origins_.assign(size(), origin_);
    const std::size_t before = size();
    addRay(origin, end, kind);
    if (size() == before) return;
    include(origin);
    if (!origins_.empty()) origins_.push_back(origin);
}

template <int Dim>
void RayBundle<Dim>::addRay(const Point<Dim>& origin, const Point<Dim>& end, RayEnd kind) {
    if (!end.allFinite()) {
        ++skipped_.notFinite;
        return;
    }
    Point<Dim> cut = end;
    const double squared = (end - origin).squaredNorm();
    if (squared < limits_.minimum * limits_.minimum) {
        ++skipped_.tooNear;
        return;
    }
    if (squared > limits_.maximum * limits_.maximum) {
        cut = origin + (end - origin) * (limits_.maximum / std::sqrt(squared));
        kind = RayEnd::open;
    }
    if (!geometry_.contains(cut)) {
        ++skipped_.outOfRange;
        return;
    }
    push(cut, kind);
}

template class RayBundle<2>;
template class RayBundle<3>;

}  // namespace superray
