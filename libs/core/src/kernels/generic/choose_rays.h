// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The choice of rays that may change the map.

#include "directions/classified_batch.h"
#include "directions/first_unsettled.h"
#include "kernels/simd/lanes.h"

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

/// As ChooseRays. Example: of a bin whose sub-bins 2 and 3 are unsettled from
/// slice 40 on, a ray in sub-bin 3 with the last slice 50 is chosen; one that
/// ends in slice 39 is not, nor is one in sub-bin 5.
template <typename Simd>
std::size_t chooseRays(const std::uint32_t* subBin, const std::uint16_t* lastSlice,
                       std::size_t count, const FirstUnsettled* unsettled,
                       std::uint32_t* chosen) {
    if constexpr (Simd::kChoiceLanes == 1) {
        std::size_t n = 0;
        for (std::size_t i = 0; i < count; ++i) {
            chosen[n] = static_cast<std::uint32_t>(i);
            const FirstUnsettled first = unsettled[subBin[i] / FirstUnsettled::kSubBins];
            n += static_cast<std::size_t>(first.slice() <= lastSlice[i]) &
                 static_cast<std::size_t>(first.contains(subBin[i]));
        }
        return n;
    } else {
        constexpr std::size_t kLanes = Simd::kChoiceLanes;
        std::uint32_t* out = chosen;
        auto ray = Simd::raysFrom(0);
        for (std::size_t i = 0; i < count; i += kLanes, ray += kLanes)
            out = Simd::compress(out, ray,
                                 Simd::template choosable<DirectionBins<3>::kSubBinBits>(
                                     subBin + i, lastSlice + i, count - i, unsettled));
        return static_cast<std::size_t>(out - chosen);
    }
}

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
