// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Scans of all scenes, and what the kernels find of their rays.

#include <superray/core/detail/cpu_target.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <vector>

#include "core/dims.h"
#include "core/ray_generators.h"
#include "kernels/walk_kernel.h"
#include "skipping/direction_ranges.h"

namespace superray::test {

inline constexpr int kRays = 3000;
inline constexpr std::size_t kScans = 2 * std::size(kScenes);

/// Calls check(rays) for a scan of every scene, in double and in single precision, and
/// counts rays.
template <int Dim, typename Check>
std::size_t forEachScene(const Check& check) {
    std::size_t count = 0, singles = 0;
    for (Scene scene : kScenes) {
        Random random(900 + static_cast<std::uint64_t>(scene));
        const auto scan = makeScan<Dim>(scene, random, CellGeometry<Dim>(0.1), kRays);
        for (const RayBundle<Dim>& rays : {scan, rounded(scan)}) {
            count += rays.size();
            singles += rays.singlePrecision();
            check(rays);
            if (::testing::Test::HasFatalFailure()) return 0;
        }
    }
    EXPECT_EQ(singles, kScans / 2);
    return count;
}

template <int Dim>
std::vector<WalkKernels<Dim>> allKernels() {
    std::vector<WalkKernels<Dim>> kernels{portableKernels<Dim>()};
#if defined(__x86_64__)
    if (bestInstructionSet() >= InstructionSet::avx2) kernels.push_back(avx2Kernels<Dim>());
    if (bestInstructionSet() >= InstructionSet::avx512) kernels.push_back(avx512Kernels<Dim>());
#endif
    return kernels;
}

template <int Dim>
RayLine<Dim> lineOf(const RayBundle<Dim>& scan, std::size_t ray) {
    return RayLine<Dim>(scan.geometry(), scan.commonOrigin(), scan.end(ray));
}

/// ClassifiedBatch of all rays from `first` on.
template <int Dim>
struct ClassifiedScan {
    DirectionBins<Dim> bins;
    std::vector<std::uint32_t> subBin;
    std::vector<std::uint16_t> lastSlice;
    std::vector<CellOffset> endOffset;
    std::vector<std::uint32_t> block;
    std::vector<std::uint16_t> local;
    std::vector<std::uint32_t> runs;  ///< where they begin
    std::uint32_t sectors = 0;
};

/// Calls use(first ray, number of rays, directions) for pieces of a scan.
template <int Dim, typename Use>
void inPieces(const WalkKernels<Dim>& kernels, const RayBundle<Dim>& scan, std::size_t first,
              ClassifiedScan<Dim>& all, const Use& use) {
    const BlockBox<Dim> box{blockOf<Dim>(scan.geometry().cellOf(scan.lowest())),
                            blockOf<Dim>(scan.geometry().cellOf(scan.highest()))};
    BlockDirectory<Dim> directory;
    directory.reset(box);
    constexpr std::size_t kSlack = ClassifiedBatch<Dim>::kSlack;
    all.subBin.resize(scan.size() - first + kSlack);
    all.lastSlice.resize(scan.size() - first + kSlack);
    const auto piece = std::make_unique<ClassifiedBatch<Dim>>();
    for (std::size_t at = first; at < scan.size(); at += ClassifiedBatch<Dim>::kMost) {
        const std::size_t count = std::min(ClassifiedBatch<Dim>::kMost, scan.size() - at);
        kernels.classifyRays(scan, at, count, directory, all.bins,
                             all.subBin.data() + (at - first),
                             all.lastSlice.data() + (at - first), *piece);
        use(at, count, *piece);
    }
}

template <int Dim>
ClassifiedScan<Dim> classify(const RayBundle<Dim>& scan, int levels,
                             const WalkKernels<Dim>& kernels = bestKernels<Dim>(),
                             std::size_t first = 0) {
    ClassifiedScan<Dim> all;
    all.bins.levels = levels;
    inPieces(kernels, scan, first, all,
             [&](std::size_t at, std::size_t count, const ClassifiedBatch<Dim>& d) {
                 const auto n = static_cast<std::ptrdiff_t>(count);
                 all.endOffset.insert(all.endOffset.end(), d.endOffset.begin(),
                                      d.endOffset.begin() + n);
                 all.block.insert(all.block.end(), d.block.begin(), d.block.begin() + n);
                 all.local.insert(all.local.end(), d.local.begin(), d.local.begin() + n);
                 all.sectors |= d.sectors;
                 std::vector<std::uint32_t> starts(count + 16);
                 const std::size_t runs =
                     kernels.findRuns(d, scan.kinds() + at, count, starts.data());
                 for (std::size_t i = 0; i < runs; ++i)
                     all.runs.push_back(static_cast<std::uint32_t>(at - first) + starts[i]);
             });
    all.subBin.resize(scan.size() - first);  // vector loads are over
    return all;
}

/// The ranges of a scan, not marked anywhere.
template <int Dim>
DirectionRanges<Dim> rangesOf(const RayBundle<Dim>& scan, ClassifiedScan<Dim> classified) {
    DirectionRanges<Dim> ranges;
    auto builder = std::make_unique<typename DirectionRanges<Dim>::Builder>(
        ranges, classified.bins, RayLine<Dim>::unitsOf(scan.geometry(), scan.commonOrigin()));
    inPieces(bestKernels<Dim>(), scan, 0, classified,
             [&](std::size_t, std::size_t count, const ClassifiedBatch<Dim>& batch) {
                 std::vector<std::uint32_t> rays(count);
                 std::iota(rays.begin(), rays.end(), 0);
                 builder->add(batch, rays.data(), count);
             });
    builder.reset();  // completes the ranges
    return ranges;
}

}  // namespace superray::test
