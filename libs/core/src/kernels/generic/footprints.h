// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Through which sub-bins of a sector the cells of a block are seen.

#include <superray/core/block.h>

#include "directions/first_unsettled.h"
#include "directions/ranges_view.h"
#include "kernels/simd/lanes.h"

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

/// The first and the last sub-bin of a footprint along one minor axis.
struct SubBinRange {
    std::int32_t first, last;
};

/// Slopes from `from` / far to `to` / near, in sub-bins. Beyond the last
/// sub-bin: seen by none.
SUPERRAY_INLINE std::int32_t firstSubBinOf(float from, float perFar, float subBinsPerAxis) {
    const float subBin = (from * perFar - kSlopeError) * subBinsPerAxis;
    return static_cast<std::int32_t>(subBin < 0                    ? 0.0f
                                     : subBin > subBinsPerAxis + 1 ? subBinsPerAxis + 1
                                                                   : subBin);
}
SUPERRAY_INLINE std::int32_t lastSubBinOf(float to, float perNear, float subBinsPerAxis) {
    const float subBin = (to * perNear + kSlopeError) * subBinsPerAxis;
    const float last = subBinsPerAxis - 1;
    return static_cast<std::int32_t>(subBin < 0 ? 0.0f : subBin > last ? last : subBin);
}
SUPERRAY_INLINE float perFarOf(float far) {
    return 1 / (far > 1e-6f ? far : 1e-6f);
}

/// Footprints of cells are products over the minor axes: of each, all that a
/// block needs are computed first.
template <int Dim>
struct Footprints {
    static constexpr int kEdge = kBlockEdge;
    static constexpr int kMinors = Dim - 1;

    std::uint64_t offset[Dim][kEdge];  ///< per axis: its part of the packed offset
    std::uint32_t seen[Dim];           ///< bit per cell along an axis: not behind the sensor
    std::int32_t slice[kEdge];
    float subBinsPerAxis;
    float entry[kEdge];  ///< where slices begin, from the origin [cells]
    float from[kMinors][kEdge], to[kMinors][kEdge];  ///< of cells, from the origin
    /// First and last sub-bins, [.][minor][major].
    std::int32_t low[kMinors][kEdge][kEdge], high[kMinors][kEdge][kEdge];

    Footprints(const RangesView<Dim>& h, const BlockInSector<Dim>& s,
               const BlockKey<Dim>& block)
        : subBinsPerAxis(
              static_cast<float>(h.bins.edge(0) * DirectionBins<Dim>::kAxisSubBins)) {
        const int d = s.major;
        float away[Dim][kEdge], within[Dim];
        for (int a = 0; a < Dim; ++a) {
            within[a] = s.back[a] ? 1 - h.within[a] : h.within[a];
            const std::int32_t first = block[a] * kEdge - h.sensor[a];
            seen[a] = 0;
            for (int i = 0; i < kEdge; ++i) {
                const std::int32_t cells = s.back[a] ? -(first + i) : first + i;
                seen[a] |= static_cast<std::uint32_t>(cells >= 0) << i;
                offset[a][i] = static_cast<std::uint64_t>(cells >= 0 ? cells : 0)
                               << (CellOffset::kBits * a);
                away[a][i] = static_cast<float>(cells);
                // Beyond 2^16 - 2 slices, rays begin there at the latest.
                if (a == d) slice[i] = cells < kNoSlice - 1 ? cells : kNoSlice - 1;
            }
        }
        float perNear[kEdge], perFar[kEdge];
        for (int i = 0; i < kEdge; ++i) {
            entry[i] = away[d][i] - within[d];
            perNear[i] = perNearOf(entry[i]);
            perFar[i] = perFarOf(entry[i] + 1);
        }
        for (int a = 0, m = 0; a < Dim; ++a) {
            if (a == d) continue;
            for (int j = 0; j < kEdge; ++j) {
                const float begin = from[m][j] = away[a][j] - within[a] - kLag;
                const float end = to[m][j] = begin + 1 + 2 * kLag;
                for (int i = 0; i < kEdge; ++i) {
                    low[m][j][i] = firstSubBinOf(begin, perFar[i], subBinsPerAxis);
                    high[m][j][i] = lastSubBinOf(end, perNear[i], subBinsPerAxis);
                }
            }
            ++m;
        }
    }

    /// Of the cells `near` to `far` along a minor axis.
    SUPERRAY_INLINE SubBinRange range(int m, int near, int far, int i) const {
        return {low[m][near][i], high[m][far][i]};
    }
    /// The same of a part of the slice, 0 <= begin < end <= 1.
    SUPERRAY_INLINE SubBinRange rangeOfPart(int m, int near, int far, int i, float begin,
                                            float end) const {
        return {firstSubBinOf(from[m][near], perFarOf(entry[i] + end), subBinsPerAxis),
                lastSubBinOf(to[m][far], perNearOf(entry[i] + begin), subBinsPerAxis)};
    }
};

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
