// SPDX-License-Identifier: BSD-3-Clause
#include "skipping/skipping_walk.h"

#include <algorithm>
#include <optional>

namespace superray {
namespace {

/// Whether growing the region again may save more than it takes, by what it took last time.
bool worthGrowing(double slicesLeft, const Boundary& last) {
    return slicesLeft > SkippingCosts::kWorthGrowing * static_cast<double>(last.work);
}

}  // namespace

template <int Dim>
void SkippingWalk<Dim>::classify(const SkippingScan<Dim>& scan, RayChunk chunk,
                                 ScanCounts<Dim>& counts) {
    if (chunk.size() == 0) return;
    counts.setHitsToSaturate(scan.limits.hits);
    classifier_.classify(scan, chunk, counts, rays_, ranges_);
}

template <int Dim>
ChunkReport SkippingWalk<Dim>::run(const SkippingScan<Dim>& scan, RayChunk chunk,
                                   ScanCounts<Dim>& counts) {
    const WorkQueue::Round round(shared_->queue);  // helpers may come; also ends it on failure
    ChunkReport report;
    const Stage stage{scan, chunk, counts, report};
    walker_.start(scan, counts);
    if (chunk.size() == 0) return report;

    report.work = SkippingCosts::kWorkOfAnyRay * static_cast<double>(chunk.size());
    region_.reset(counts.directory.box(), scan.map, scan.limits, scan.hitsOfAll);
    Boundary boundary = grow(stage);
    if (!boundary.sensorCellSettled) {
        // Nothing is settled for any ray, however well known the rest of the map is. A few
        // rays settle the cells around the sensor.
        const std::vector<std::uint32_t>& few = smallSample_.of(chunk.size());
        if (few.size() >= SkippingCosts::kLeastSample) {
            walkSample(stage, few);
            boundary = grow(stage);
        }
    }
    if (scan.sampling == Sampling::whereItMayPay) sample(stage, boundary);
    walk(stage, select(stage));
    return report;
}

template <int Dim>
void SkippingWalk<Dim>::help(SharedJob<Dim>& other) {
    other.queue.help([&](WorkPiece piece) { walker_.walk(other.job, piece); });
    walker_.flush();
}

/// Grows the settled region from the sensor's cell, and marks its boundary in the ranges.
template <int Dim>
Boundary SkippingWalk<Dim>::grow(const Stage& stage) {
    return region_.grow(stage.scan.sensorCell, stage.counts, ranges_,
                        SkippingCosts::kGrowthPerRay * stage.chunk.size());
}

/// Walks a part of the rays and grows the region again, if the others are likely to be
/// spared more than that takes. In scans with few rays per bin a sample saves nothing; that
/// is reported as its effect.
/// \return the last boundary
template <int Dim>
Boundary SkippingWalk<Dim>::sample(const Stage& stage, Boundary boundary) {
    const std::size_t count = stage.chunk.size();
    SampleEffect& effect = stage.report.sample;
    const double raysPerBin =
        static_cast<double>(count) / static_cast<double>(ranges_.binsWithRays());
    if (raysPerBin <= SkippingCosts::kDense) {
        const double slices = slicesLeft();
        if (worthGrowing(slices, boundary)) effect = {slices, slices};
        return boundary;
    }
    std::optional<double> before;
    for (RaySample* const some : {&smallSample_, &sample_}) {
        if (some == &smallSample_ && raysPerBin < SkippingCosts::kVeryDense) continue;
        if (!worthGrowing(slicesLeft(), boundary)) break;
        if (walkSample(stage, some->of(count)) == 0) continue;
        const double slices = slicesLeft();
        if (!worthGrowing(slices, boundary)) break;
        boundary = grow(stage);
        if (!before) before = slices;
    }
    if (before) effect = {*before, slicesLeft()};
    return boundary;
}

/// Slices in which the rays of the chunk may change the map, estimated from some of them.
template <int Dim>
double SkippingWalk<Dim>::slicesLeft() const {
    constexpr std::size_t kEvery = SkippingCosts::kEstimateEvery;
    double slices = 0;
    for (std::size_t i = 0; i < rays_.size(); i += kEvery)
        slices += std::max(0, rays_.lastSlice(i) + 1 - ranges_.firstUnsettled(rays_.subBin(i)));
    return slices * kEvery;
}

/// Walks those of some rays that may change the map.
/// \return how many these were
template <int Dim>
std::size_t SkippingWalk<Dim>::walkSample(const Stage& stage,
                                          const std::vector<std::uint32_t>& rays) {
    chosen_.reserve(rays_.size() + ClassifiedBatch<Dim>::kSlack);
    std::size_t n = 0;
    for (const std::uint32_t ray : rays) {
        chosen_[n] = ray;
        n += ranges_.firstUnsettled(rays_.subBin(ray)) <= rays_.lastSlice(ray);
    }
    addWork(stage.report, n, 1);
    walker_.walk({stage.chunk.first, &rays_, &ranges_, chosen_.data()}, {0, n});
    walker_.flush();
    for (std::size_t i = 0; i < n; ++i) rays_.markFinished(chosen_[i]);
    return n;
}

/// Adds the slices of the first `chosen` chosen rays to the work, by one in `every` of them.
template <int Dim>
void SkippingWalk<Dim>::addWork(ChunkReport& report, std::size_t chosen,
                                std::size_t every) const {
    std::size_t slices = 0;
    for (std::size_t i = 0; i < chosen; i += every) {
        const std::uint32_t ray = chosen_[i];
        slices += static_cast<std::size_t>(rays_.lastSlice(ray) + 1 -
                                           ranges_.firstUnsettled(rays_.subBin(ray)));
    }
    report.work += static_cast<double>(slices * every);
}

/// Chooses the rays that pass a marked sub-bin at or before their end.
/// \return how many
template <int Dim>
std::size_t SkippingWalk<Dim>::select(const Stage& stage) {
    chosen_.reserve(rays_.size() + ClassifiedBatch<Dim>::kSlack);
    return kernelsFor(stage.counts.directory)
        .chooseRays(rays_.subBins(), rays_.lastSlices(), rays_.size(), ranges_.unsettled(),
                    chosen_.data());
}

/// Walks the chosen rays, piece by piece. Other threads take pieces, too, so nothing that a
/// job refers to changes from here on.
template <int Dim>
void SkippingWalk<Dim>::walk(const Stage& stage, std::size_t chosen) {
    shared_->job = {stage.chunk.first, &rays_, &ranges_, chosen_.data()};
    shared_->queue.publish(chosen);
    addWork(stage.report, chosen, SkippingCosts::kWorkEvery);
    while (const auto piece = shared_->queue.take()) walker_.walk(shared_->job, *piece);
    walker_.flush();
}

template class SkippingWalk<2>;
template class SkippingWalk<3>;

}  // namespace superray
