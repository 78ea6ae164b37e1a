#include <superray/core/ray_bundle.h>

#include <sstream>
#include <stdexcept>

namespace superray {

void RangeLimits::validate() const {
    if (minimum >= 0 && minimum < maximum) return;
    std::ostringstream message;
    message << "range limits minimum = " << minimum << " m, maximum = " << maximum
            << " m: must satisfy 0 <= minimum < maximum";
    throw std::invalid_argument(message.str());
}

template <int Dim>
RayBundle<Dim>::RayBundle(const CellGeometry<Dim>& geometry, const Point<Dim>& origin,
                          const RangeLimits& limits)
    : geometry_(geometry), origin_(origin), limits_(limits) {
    limits_.validate();
    if (geometry_.contains(origin)) return;
    std::ostringstream message;
    message << "sensor origin (" << origin.transpose() << ") m: must be finite and within +-"
            << kCellLimit * geometry.resolution() << " m (" << kCellLimit << " cells of "
            << geometry.resolution() << " m)";
    throw std::invalid_argument(message.str());
}

template <int Dim>
void RayBundle<Dim>::reserve(std::size_t n) {
    ends_.reserve(n);
    kinds_.reserve(n);
}

template <int Dim>
void RayBundle<Dim>::add(const Point<Dim>& origin, const Point<Dim>& end, RayEnd kind) {
    if (!geometry_.contains(origin)) {
        ++(origin.allFinite() ? skipped_.outOfRange : skipped_.notFinite);
        return;
    }
    if (origins_.empty() && origin != origin_) origins_.assign(ends_.size(), origin_);
    const std::size_t before = ends_.size();
    addRay(origin, end, kind);
    if (ends_.size() > before && !origins_.empty()) origins_.push_back(origin);
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
    ends_.push_back(cut);
    kinds_.push_back(kind);
}

template class RayBundle<2>;
template class RayBundle<3>;

}  // namespace superray
