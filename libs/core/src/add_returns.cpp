// SPDX-License-Identifier: BSD-3-Clause
// Many returns at once into a bundle: apart from the rest of it, as kernels copy them.

#include <superray/core/detail/parallel.h>
#include <superray/core/ray_bundle.h>

#include "kernels/walk_kernel.h"
#include "tuning.h"

#include <algorithm>
#include <mutex>
#include <type_traits>
#include <vector>

namespace superray {

/// Adds returns as they are, if they all are good.
/// \pre room is reserved; coordinates are kept as Scalar
template <int Dim>
template <typename Scalar>
bool RayBundle<Dim>::addGoodReturns(const Scalar* ends, std::size_t count, unsigned threads) {
    static const CopyPoints<Dim, Scalar> copyPoints = bestKernels<Dim>().copy(Scalar{});
    if (!unlimited_ || !origins_.empty()) return false;
    PerAxis<Scalar>& to = coordinates<Scalar>();
    const std::size_t chunks = chunkCountFor(count, CountingCosts::kPointsPerChunk, threads);
    std::mutex mutex;  // of these:
    bool good = true;
    Point<Dim> lowest = lowest_, highest = highest_;
    inParallel(chunks, [&](std::size_t s) {
        const std::size_t first = chunkBegin(count, s, chunks);
        const std::size_t last = chunkBegin(count, s + 1, chunks);
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
    constexpr std::size_t kBatch = CountingCosts::kPointsAtOnce;
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

template void RayBundle<2>::addReturns(const float*, std::size_t, unsigned);
template void RayBundle<2>::addReturns(const double*, std::size_t, unsigned);
template void RayBundle<3>::addReturns(const float*, std::size_t, unsigned);
template void RayBundle<3>::addReturns(const double*, std::size_t, unsigned);

}  // namespace superray
