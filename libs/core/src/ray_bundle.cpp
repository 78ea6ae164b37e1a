#include <superray/core/parallel.h>
#include <superray/core/ray_bundle.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "memory/scratch_array.h"
#include "kernels/walk_kernel.h"

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

/// Adds returns as they are, if they all are good.
/// \pre room is reserved; coordinates are kept as Scalar
template <int Dim>
template <typename Scalar>
bool RayBundle<Dim>::addGoodReturns(const Scalar* ends, std::size_t count, unsigned threads) {
    static const CopyPoints<Dim, Scalar> copyPoints = bestKernels<Dim>().copy(Scalar{});
    constexpr std::size_t kPerShare = 1 << 14;  // repays a thread
    if (!unlimited_ || !origins_.empty()) return false;
    PerAxis<Scalar>& to = coordinates<Scalar>();
    const std::size_t shares = shareCountFor(count, kPerShare, threads);
    std::mutex mutex;  // of these:
    bool good = true;
    Point<Dim> lowest = lowest_, highest = highest_;
    inParallel(shares, [&](std::size_t s) {
        const std::size_t first = shareBegin(count, s, shares);
        const std::size_t last = shareBegin(count, s + 1, shares);
        PointBatch<Dim, Scalar> batch;
        for (int a = 0; a < Dim; ++a) batch.coordinates[a] = to[a].end() + first;
        batch.lowest = lowest_;
        batch.highest = highest_;
        const bool allGood =
            copyPoints(ends + first * Dim, last - first, geometry_.scaled(1.0), batch);
        const std::lock_guard<std::mutex> lock(mutex);
        good &= allGood;
        lowest = lowest.cwiseMin(batch.lowest);
        highest = highest.cwiseMax(batch.highest);
    });
    if (!good) return false;
    for (auto& c : to) c.grow(count);
    kinds_.resize(kinds_.size() + count, RayEnd::hit);
    lowest_ = lowest;
    highest_ = highest;
    return true;
}

/// Where all points of a batch are good, which is the rule, they are copied as they are;
/// else they are taken one by one.
template <int Dim>
template <typename Scalar>
void RayBundle<Dim>::addPoints(const Scalar* ends, std::size_t count, unsigned threads) {
    reserve(size() + count);
    if (threads > 1 && addGoodReturns(ends, count, threads)) return;
    constexpr std::size_t kBatch = 512;
    for (std::size_t first = 0; first < count; first += kBatch) {
        const std::size_t n = std::min(kBatch, count - first);
        const Scalar* const batch = ends + first * Dim;
        // Cutting to range may make numbers that single precision does not hold.
        const bool asKept = single_ == std::is_same_v<Scalar, float>;
        if (asKept && addGoodReturns(batch, n, 1)) continue;
        for (std::size_t i = 0; i < n; ++i) {
            Point<Dim> p;
            for (int a = 0; a < Dim; ++a) p[a] = static_cast<double>(batch[i * Dim + a]);
            add(p);
        }
    }
}

template <int Dim>
void RayBundle<Dim>::addReturns(const float* ends, std::size_t count, unsigned threads) {
    if (single_) return addPoints(ends, count, threads);
    const std::vector<double> doubles(ends, ends + count * Dim);
    addPoints(doubles.data(), count, threads);
}

template <int Dim>
void RayBundle<Dim>::addReturns(const double* ends, std::size_t count, unsigned threads) {
    if (single_) useDoubles();
    addPoints(ends, count, threads);
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

template class Coordinates<float>;
template class Coordinates<double>;
template class RayBundle<2>;
template class RayBundle<3>;

}  // namespace superray
