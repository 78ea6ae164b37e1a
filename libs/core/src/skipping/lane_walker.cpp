// SPDX-License-Identifier: BSD-3-Clause
#include "skipping/lane_walker.h"

#include "tuning.h"

#include <algorithm>
#include <iterator>

namespace superray {
namespace {

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
void LaneWalker<Dim>::start(const SkippingScan<Dim>& scan, ScanCounts<Dim>& counts) {
    scan_ = &scan;
    counts_ = &counts;
    kernels_ = kernelsFor(counts.directory);
    walkedInFull_ = 0;
    for (std::uint32_t sector = 0; sector < waiting_.size(); ++sector)
        for (RayLanes& lanes : waiting_[sector]) lanes.sector = sector;
}

template <int Dim>
void LaneWalker<Dim>::walk(const WalkJob<Dim>& job, WorkPiece piece) {
    const ClassifiedRays<Dim>& rays = *job.rays;
    for (std::size_t i = piece.begin; i < piece.end; ++i) {
        const std::uint32_t ray = job.chosen[i];
        const std::size_t later =
            job.chosen[std::min(i + SkippingCosts::kPrefetchAhead, piece.end - 1)];
        prefetchEnd(scan_->rays, job.first + later);
        const std::int32_t from = job.ranges->firstUnsettled(rays.subBin(ray));
        walkedInFull_ += from == 0;
        if (rays.unclassified(ray)) {
            walkUnclassified(job.first + ray);
            continue;
        }
        // An index, not a branch: half of the rays would be mispredicted.
        const auto few =
            static_cast<std::size_t>(from > 0) &
            static_cast<std::size_t>(rays.lastSlice(ray) - from < SkippingCosts::kFewSlices);
        RayLanes& lanes = waiting_[rays.bins().sectorOf(rays.subBin(ray))][few];
        lanes.ray[lanes.count] = static_cast<std::uint32_t>(job.first) + ray;
        lanes.from[lanes.count] = from;
        if (++lanes.count == 8) walkLanes(lanes, few ? kernels_.walkEnds : kernels_.walkRays);
    }
}

template <int Dim>
void LaneWalker<Dim>::flush() {
    for (auto& [many, few] : waiting_) {
        walkLanes(many, kernels_.walkRays);
        walkLanes(few, kernels_.walkEnds);
    }
    counts_->flush(1);
}

/// Walks a ray whose direction single precision cannot tell, from its beginning.
template <int Dim>
void LaneWalker<Dim>::walkUnclassified(std::size_t ray) {
    const RayBundle<Dim>& rays = scan_->rays;
    const RayLine<Dim> line(scan_->origin,
                            RayLine<Dim>::unitsOf(rays.geometry(), rays.end(ray)));
    counts_->addresses.reserveMore(static_cast<std::size_t>(line.steps()));
    kernels_.walk(*counts_, line, 0);
}

template <int Dim>
void LaneWalker<Dim>::walkLanes(RayLanes& lanes, WalkRays<Dim> kernel) {
    if (lanes.count == 0) return;
    if (counts_->addresses.size() >= CountingCosts::kFlushAt) counts_->flush(1);
    std::fill(lanes.ray + lanes.count, std::end(lanes.ray), lanes.ray[0]);
    kernel(*counts_, scan_->rays, lanes);
    lanes.count = 0;
}

template class LaneWalker<2>;
template class LaneWalker<3>;

}  // namespace superray
