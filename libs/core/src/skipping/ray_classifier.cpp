// SPDX-License-Identifier: BSD-3-Clause
#include "skipping/ray_classifier.h"

#include "directions/scan_bounds.h"
#include "tuning.h"

#include <algorithm>

namespace superray {
namespace {

/// Bins about as wide as a cell at the end of a typical ray; twice as fine where that takes
/// few bins, or where many rays go through each.
template <int Dim>
DirectionBins<Dim> chooseBins(const RayBundle<Dim>& rays, RayChunk chunk) {
    using Costs = SkippingCosts;
    const double length = typicalLength(rays, chunk.first, chunk.last);
    int levels = 1;
    while (levels < DirectionBins<Dim>::kMostLevels) {
        const bool fine = levels < Costs::kFineLevels ||
                          chunk.size() > Costs::kRaysPerFineBin << ((Dim - 1) * (levels + 1));
        if ((1 << levels) >= (fine ? 2 * length : length)) break;
        ++levels;
    }
    DirectionBins<Dim> bins;
    bins.levels = levels;
    return bins;
}

}  // namespace

template <int Dim>
void RayClassifier<Dim>::classify(const SkippingScan<Dim>& scan, RayChunk chunk,
                                  ScanCounts<Dim>& counts, ClassifiedRays<Dim>& rays,
                                  DirectionRanges<Dim>& ranges) {
    const WalkKernels<Dim>& kernels = kernelsFor(counts.directory);
    rays.reset(chooseBins(scan.rays, chunk), chunk.size());
    {
        typename DirectionRanges<Dim>::Builder builder(ranges, rays.bins(), scan.origin);
        for (std::size_t at = 0; at < chunk.size(); at += ClassifiedBatch<Dim>::kMost) {
            const std::size_t n = std::min(ClassifiedBatch<Dim>::kMost, chunk.size() - at);
            const std::size_t first = chunk.first + at;
            kernels.classifyRays(scan.rays, first, n, counts.directory, rays.bins(),
                                 rays.subBins() + at, rays.lastSlices() + at, batch_);
            const std::size_t runs =
                kernels.findRuns(batch_, scan.rays.kinds() + first, n, runStarts_.data());
            runStarts_[runs] = static_cast<std::uint32_t>(n);
            builder.add(batch_, runStarts_.data(), runs);
            hitCounter_.count(counts, scan.rays, first, batch_, runStarts_.data(), runs);
        }
    }
    counts.settleSaturatedHits();
}

template class RayClassifier<2>;
template class RayClassifier<3>;

}  // namespace superray
