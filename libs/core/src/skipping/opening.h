#pragma once
// Where the rays of a tile begin to have something to tell.

#include <cstdint>
#include <limits>

namespace superray {

using Slice = std::uint16_t;
inline constexpr Slice kNoSlice = std::numeric_limits<Slice>::max();

/// The first slice in which a ray of the tile has something to tell, and bit by bit, in
/// which of the tile's spots rays have, there or farther away.
struct Opening {
    static constexpr int kSpots = 16;
    static constexpr std::uint32_t kAllSpots = (1u << kSpots) - 1;

    std::uint32_t word;  ///< slice << kSpots | spots

    static constexpr Opening of(Slice slice, std::uint32_t spots) {
        return {std::uint32_t{slice} << kSpots | spots};
    }
    static constexpr Opening never() { return of(kNoSlice, 0); }
    static constexpr Opening all(Slice slice) { return of(slice, kAllSpots); }

    Slice slice() const { return static_cast<Slice>(word >> kSpots); }
    std::uint32_t spots() const { return word & kAllSpots; }
    bool opens(std::uint32_t spot) const { return (word >> (spot % kSpots) & 1) != 0; }
    Opening joined(Opening o) const {
        const std::uint32_t first = word < o.word ? word : o.word;
        return {(first & ~kAllSpots) | ((word | o.word) & kAllSpots)};
    }
};

}  // namespace superray
