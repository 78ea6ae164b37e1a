// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The first slice of a direction bin that may still change the map.

#include <cstdint>
#include <limits>

namespace superray {

using Slice = std::uint16_t;
inline constexpr Slice kNoSlice = std::numeric_limits<Slice>::max();

/// A slice and a mask of sub-bins. Rays of the marked sub-bins may change the map in that slice
/// or later; those of the others cannot. A smaller word is an earlier slice.
struct FirstUnsettled {
    static constexpr int kSubBins = 16;
    static constexpr std::uint32_t kAllSubBins = (1u << kSubBins) - 1;

    std::uint32_t word;  ///< slice << kSubBins | sub-bins

    static constexpr FirstUnsettled of(Slice slice, std::uint32_t subBins) {
        return {std::uint32_t{slice} << kSubBins | subBins};
    }
    static constexpr FirstUnsettled never() { return of(kNoSlice, 0); }
    static constexpr FirstUnsettled all(Slice slice) { return of(slice, kAllSubBins); }

    Slice slice() const { return static_cast<Slice>(word >> kSubBins); }
    std::uint32_t subBins() const { return word & kAllSubBins; }
    bool contains(std::uint32_t subBin) const { return (word >> (subBin % kSubBins) & 1) != 0; }
    FirstUnsettled joined(FirstUnsettled o) const {
        const std::uint32_t first = word < o.word ? word : o.word;
        return {(first & ~kAllSubBins) | ((word | o.word) & kAllSubBins)};
    }
};

}  // namespace superray
