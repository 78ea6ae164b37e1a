#include <superray/core/ray_bundle.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

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
