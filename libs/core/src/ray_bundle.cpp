// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/ray_bundle.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "memory/scratch_array.h"

namespace superray {

void RangeLimits::validate() const {
    if (minimum >= 0 && minimum < maximum) return;
    std::ostringstream message;
    message << "range limits minimum = " << minimum << " m, maximum = " << maximum
            << " m: must satisfy 0 <= minimum < maximum";
    throw std::invalid_argument(message.str());
}

template <typename Scalar>
Coordinates<Scalar>::Coordinates(const Coordinates& o) {
    reserve(o.size_);
    std::copy_n(o.values_.get(), o.size_, values_.get());
    size_ = o.size_;
}

template <typename Scalar>
void Coordinates<Scalar>::reserve(std::size_t n) {
    if (n <= capacity_) return;
    const std::size_t capacity = withRoomForMore(n);
    std::unique_ptr<Scalar[]> larger(new Scalar[capacity]);
    std::copy_n(values_.get(), size_, larger.get());
    values_ = std::move(larger);
    capacity_ = capacity;
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
    single_ = true;
    for (auto& c : singles_) c.clear();
    for (auto& c : doubles_) c.clear();
    kinds_.clear();
    origins_.clear();
    skipped_ = {};
}

template <int Dim>
void RayBundle<Dim>::reserve(std::size_t n) {
    visitKept([&](auto& ends) {
        for (auto& c : ends) c.reserve(n);
    });
    if (n > kinds_.capacity()) kinds_.reserve(withRoomForMore(n));
}

template <int Dim>
void RayBundle<Dim>::useDoubles() {
    for (int a = 0; a < Dim; ++a) {
        doubles_[a].reserve(singles_[a].capacity());
        std::copy_n(singles_[a].data(), singles_[a].size(), doubles_[a].end());
        doubles_[a].grow(singles_[a].size());
    }
    single_ = false;
}

template <int Dim>
void RayBundle<Dim>::restartLike(const RayBundle& other) {
    geometry_ = other.geometry_;
    restart(other.origin_);
    lowest_ = other.lowest_;
    highest_ = other.highest_;
    single_ = other.single_;
    reserve(other.size());
    visitKept([&](auto& ends) {
        for (auto& c : ends) c.grow(other.size());
    });
    kinds_.resize(other.size());
}

template <int Dim>
void RayBundle<Dim>::add(const Point<Dim>& origin, const Point<Dim>& end, RayEnd kind) {
    if (!geometry_.contains(origin)) {
        ++(origin.allFinite() ? skipped_.outOfRange : skipped_.notFinite);
        return;
    }
    const std::size_t before = size();
    addRay(origin, end, kind);
    if (size() == before) return;
    include(origin);
    if (origins_.empty() && origin == origin_) return;
    if (origins_.empty()) origins_.assign(before, origin_);
    origins_.push_back(origin);
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
        kind = RayEnd::noReturn;
    }
    if (!geometry_.contains(cut)) {
        ++skipped_.outOfRange;
        return;
    }
    push(cut, kind);
}

template class Coordinates<float>;
template class Coordinates<double>;
template class RayBundle<2>;
template class RayBundle<3>;

}  // namespace superray
