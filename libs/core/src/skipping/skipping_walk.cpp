// SPDX-License-Identifier: BSD-3-Clause
#include "skipping/skipping_walk.h"

#include "directions/scan_bounds.h"

#include <algorithm>
#include <optional>

namespace superray {
namespace {

/// Looking around again must be likely to save so many times its work.
constexpr double kWorthGrowing = 4;
/// Rays per bin from which on this may pay at all: rays that are walked out of
/// the sensor's order find less in the cache.
constexpr double kDense = 3.5;
/// So many rays at least may settle the cells that all of them pass.
constexpr std::size_t kFewest = 16;
/// Rays per bin from which on the rays to walk first should be spared something, too.
constexpr double kVeryDense = 16;

/// Most work of looking around, per ray: about what it takes to walk a ray through
/// as many cells.
constexpr std::size_t kWorkPerRay = 4;

/// So many chosen rays ahead, coordinates are fetched into the cache.
constexpr std::size_t kAhead = 32;

/// What there is to do for any ray, in slices; and so many of the chosen ones tell for all.
constexpr double kWorkOfAnyRay = 8;
constexpr std::size_t kChosenForOne = 16;

/// Fewer slices than these are walked side by side.
constexpr std::int32_t kFewSlices = 6;

/// Addresses gathered before they are counted: enough to keep the counting loop
/// free of mispredictions, few enough to stay in the L1 cache.
constexpr std::size_t kFlushAt = 2048;

template <int Dim>
void prefetchEnd(const RayBundle<Dim>& rays, std::size_t ray) {
    for (int a = 0; a < Dim; ++a) {
        if (rays.singlePrecision())
            __builtin_prefetch(rays.template ends<float>(a) + ray);
        else
            __builtin_prefetch(rays.template ends<double>(a) + ray);
    }
}

}  // namespace

template <int Dim>
void SkippingWalk<Dim>::begin(const SkippingScan<Dim>& scan, ScanCounts<Dim>& counts) {
    static const WalkKernels<Dim> best = bestKernels<Dim>(), portable = portableKernels<Dim>();
    kernels_ = counts.directory.dense() ? best : portable;
    rays_ = &scan.rays;
    counts_ = &counts;
    counts.setHitsToSaturate(scan.limits.hits);
    region_.reset(counts.directory.box(), scan.map, scan.limits);
    sampling_ = scan.sampling;
    sampleEffect_ = {};
    culled_ = 0;
    work_ = 0;
    origin_ = RayLine<Dim>::unitsOf(rays_->geometry(), rays_->commonOrigin());
    for (std::uint32_t sector = 0; sector < waiting_.size(); ++sector)
        for (RayLanes& lanes : waiting_[sector]) lanes.sector = sector;
    queue_->start();
}

template <int Dim>
void SkippingWalk<Dim>::walk(std::size_t first, std::size_t last) {
    if (first == last) return;
    first_ = first;
    const std::size_t count = last - first;
    chooseBins(first, last);
    ranges_.reset(bins_, origin_);
    classifyRays(count);
    ranges_.completeFarthest();
    counts_->settleSaturatedHits();

    growRegion(count);
    culled_ += count;
    work_ = kWorkOfAnyRay * static_cast<double>(count);
    settleSensorCell(count);
    if (sampling_ == Sampling::whereItMayRepay) sample(count);
    walkLast(count);
}

/// Finds where rays go and end, and counts their hits.
template <int Dim>
void SkippingWalk<Dim>::classifyRays(std::size_t count) {
    constexpr std::size_t kMost = ClassifiedBatch<Dim>::kMost;
    constexpr std::size_t kSlack = ClassifiedBatch<Dim>::kSlack;
    subBin_.reserve(count + kSlack);
    lastSlice_.reserve(count + kSlack);
    chosen_.reserve(count + kSlack);
    for (std::size_t at = 0; at < count; at += kMost) {
        const std::size_t rays = std::min(kMost, count - at);
        kernels_.classifyRays(*rays_, first_ + at, rays, counts_->directory, bins_,
                              subBin_.data() + at, lastSlice_.data() + at, directions_);
        const std::size_t runs =
            kernels_.findRuns(directions_, rays_->kinds() + first_ + at, rays, starts_.data());
        starts_[runs] = static_cast<std::uint32_t>(rays);
        ranges_.addRays(directions_, starts_.data(), runs);
        hitCounter_.count(*counts_, *rays_, first_ + at, directions_, starts_.data(), runs);
    }
}

/// In how many slices rays may have something to tell, by some of them.
template <int Dim>
double SkippingWalk<Dim>::slicesLeft(std::size_t count) const {
    constexpr std::size_t kEach = 101;
    double slices = 0;
    for (std::size_t i = 0; i < count; i += kEach)
        slices += std::max(0, lastSlice_[i] + 1 - ranges_.firstUnsettled(subBin_[i]));
    return slices * kEach;
}

/// Whether looking around again may save more than it takes.
template <int Dim>
bool SkippingWalk<Dim>::worthGrowing(double slices) const {
    return slices > kWorthGrowing * static_cast<double>(region_.work());
}

/// Where the sensor's own cell is open, nothing is settled yet for any ray, however well
/// known the rest of the map: a few rays settle it.
template <int Dim>
void SkippingWalk<Dim>::settleSensorCell(std::size_t count) {
    if (!region_.empty()) return;
    const std::vector<std::uint32_t>& few = firstSample_.of(count);
    if (few.size() < kFewest) return;
    walkSample(few);
    growRegion(count);
}

/// Walks some rays and looks around again, for what they saturate, the others are spared.
/// In scans that are not dense this would spare nothing, which is noted as its effect.
template <int Dim>
void SkippingWalk<Dim>::sample(std::size_t count) {
    const double raysPerBin =
        static_cast<double>(count) / static_cast<double>(ranges_.binsWithRays());
    if (raysPerBin <= kDense) {
        const double slices = slicesLeft(count);
        if (worthGrowing(slices)) sampleEffect_ = {slices, slices};
        return;
    }
    std::optional<double> before;
    for (RaySample* const some : {&firstSample_, &sample_}) {
        if (some == &firstSample_ && raysPerBin < kVeryDense) continue;
        if (!worthGrowing(slicesLeft(count))) break;
        if (walkSample(some->of(count)) == 0) continue;
        const double slices = slicesLeft(count);
        if (!worthGrowing(slices)) break;
        growRegion(count);
        if (!before) before = slices;
    }
    if (before) sampleEffect_ = {*before, slicesLeft(count)};
}

/// Walks those of some rays that have something to tell.
/// \return how many there were
template <int Dim>
std::size_t SkippingWalk<Dim>::walkSample(const std::vector<std::uint32_t>& rays) {
    std::size_t n = 0;
    for (const std::uint32_t ray : rays) {
        chosen_[n] = ray;
        n += ranges_.firstUnsettled(subBin_[ray]) <= lastSlice_[ray];
    }
    addWork(n, 1);
    walkChosen(*this, {0, n});
    walkWaiting();
    for (std::size_t i = 0; i < n; ++i)
        subBin_[chosen_[i]] = bins_.firstSubBin(bins_.finished());
    return n;
}

/// Adds the slices of the chosen rays to the work, by one of so many.
template <int Dim>
void SkippingWalk<Dim>::addWork(std::size_t chosen, std::size_t oneOf) {
    std::size_t slices = 0;
    for (std::size_t i = 0; i < chosen; i += oneOf) {
        const std::uint32_t ray = chosen_[i];
        slices += lastSlice_[ray] + std::size_t{1} - ranges_.firstUnsettled(subBin_[ray]);
    }
    work_ += static_cast<double>(slices * oneOf);
}

/// Walks the last rays of a part that have something to tell, as far as the ranges
/// knows, with the help of others: nothing that these read may change afterwards.
template <int Dim>
void SkippingWalk<Dim>::walkLast(std::size_t count) {
    const std::size_t chosen = kernels_.chooseRays(subBin_.data(), lastSlice_.data(), count,
                                                   ranges_.unsettled(), chosen_.data());
    queue_->publish(chosen);
    addWork(chosen, kChosenForOne);
    while (const auto piece = queue_->take()) walkChosen(*this, *piece);
    walkWaiting();
}

template <int Dim>
void SkippingWalk<Dim>::help(SkippingWalk& other) {
    other.queue_->help([&](WorkPiece piece) { walkChosen(other, piece); });
    walkWaiting();
}

/// Walks rays that some thread has chosen.
template <int Dim>
void SkippingWalk<Dim>::walkChosen(const SkippingWalk& owner, WorkPiece piece) {
    for (std::size_t i = piece.begin; i < piece.end; ++i) {
        const std::uint32_t ray = owner.chosen_[i];
        const std::size_t later = owner.chosen_[std::min(i + kAhead, piece.end - 1)];
        prefetchEnd(*rays_, owner.first_ + later);
        const std::uint32_t subBin = owner.subBin_[ray];
        const std::int32_t from = owner.ranges_.firstUnsettled(subBin);
        culled_ -= from == 0;
        if (owner.bins_.binOf(subBin) == owner.bins_.unclassified()) {
            walkUnclassified(owner.first_ + ray);
            continue;
        }
        // Not a branch: one of two rays surprises.
        const auto few = static_cast<std::size_t>(from > 0) &
                         static_cast<std::size_t>(owner.lastSlice_[ray] - from < kFewSlices);
        RayLanes& lanes = waiting_[owner.bins_.sectorOf(subBin)][few];
        lanes.ray[lanes.count] = static_cast<std::uint32_t>(owner.first_) + ray;
        lanes.from[lanes.count] = from;
        if (++lanes.count == 8) walkLanes(lanes, few ? kernels_.walkEnds : kernels_.walkRays);
    }
}

/// Walks the rays that wait for others of their sector.
template <int Dim>
void SkippingWalk<Dim>::walkWaiting() {
    for (auto& [many, few] : waiting_) {
        walkLanes(many, kernels_.walkRays);
        walkLanes(few, kernels_.walkEnds);
    }
    counts_->flush(1);
}

/// Walks a ray of the unclassified bin.
template <int Dim>
void SkippingWalk<Dim>::walkUnclassified(std::size_t ray) {
    const RayLine<Dim> line(origin_, RayLine<Dim>::unitsOf(rays_->geometry(), rays_->end(ray)));
    counts_->addresses.reserveMore(static_cast<std::size_t>(line.steps()));
    kernels_.walk(*counts_, line, 0);
}

/// Bins about as wide as a cell at the end of a typical ray; finer ones where few are
/// enough for that, or there are many rays for each.
template <int Dim>
void SkippingWalk<Dim>::chooseBins(std::size_t first, std::size_t last) {
    constexpr int kFew = 5;
    constexpr std::size_t kMany = 24;
    const double length = typicalLength(*rays_, first, last);
    int levels = 1;
    while (levels < DirectionBins<Dim>::kMostLevels) {
        const bool fine = levels < kFew || last - first > kMany << ((Dim - 1) * (levels + 1));
        if ((1 << levels) >= (fine ? 2 * length : length)) break;
        ++levels;
    }
    bins_.levels = levels;
}

template <int Dim>
void SkippingWalk<Dim>::growRegion(std::size_t count) {
    region_.build(rays_->geometry().cellOf(rays_->commonOrigin()), *counts_, ranges_,
                  kWorkPerRay * count);
}

template <int Dim>
void SkippingWalk<Dim>::walkLanes(RayLanes& lanes, WalkRays<Dim> kernel) {
    if (lanes.count == 0) return;
    if (counts_->addresses.size() >= kFlushAt) counts_->flush(1);
    std::fill(lanes.ray + lanes.count, std::end(lanes.ray), lanes.ray[0]);
    kernel(*counts_, *rays_, lanes);
    lanes.count = 0;
}

template class SkippingWalk<2>;
template class SkippingWalk<3>;

}  // namespace superray
