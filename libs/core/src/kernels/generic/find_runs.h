// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Runs of rays that go and end alike.

#include "directions/classified_batch.h"
#include "kernels/simd/lanes.h"

#include <algorithm>

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

/// As FindRuns. A ray begins a run unless it has the bin, the end cell and the
/// end of the ray before it, and a bin at all. Example: of rays in the bins 4 4
/// 4 7 7, alike otherwise, the runs start at 0 and 3.
template <typename Simd, int Dim>
std::size_t findRuns(const ClassifiedBatch<Dim>& rays, const RayEnd* ends, std::size_t count,
                     std::uint32_t* starts) {
    using Bins = DirectionBins<Dim>;
    starts[0] = 0;
    std::uint32_t* out = starts + 1;
    if constexpr (Simd::kRunLanes == 1) {
        for (std::size_t i = 1; i < count; ++i) {
            const std::uint32_t bin = Bins::binOf(rays.subBin[i]);
            // Without branches: whether rays are alike cannot be foretold.
            const unsigned same = unsigned{bin == Bins::binOf(rays.subBin[i - 1])} &
                                  unsigned{bin != rays.unclassified} &
                                  unsigned{rays.endOffset[i] == rays.endOffset[i - 1]} &
                                  unsigned{ends[i] == ends[i - 1]};
            *out = static_cast<std::uint32_t>(i);
            out += 1 - same;
        }
    } else {
        constexpr std::size_t kLanes = Simd::kRunLanes;
        auto ray = Simd::raysFrom(1);
        for (std::size_t i = 1; i < count; i += kLanes, ray += kLanes) {
            const std::size_t n = std::min<std::size_t>(kLanes, count - i);
            const unsigned same =
                Simd::template sameBins<Bins::kSubBinBits>(rays.subBin + i, rays.unclassified) &
                Simd::sameOffsets(rays.endOffset.data() + i) & Simd::sameEnds(ends + i, n);
            out = Simd::compress(out, ray, ~same & ((1u << n) - 1));
        }
    }
    return static_cast<std::size_t>(out - starts);
}

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
