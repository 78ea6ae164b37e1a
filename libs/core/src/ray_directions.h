#pragma once
// Roughly where each ray of a scan goes: enough to tell which rays are
// neighbours, and to bound the cells of neighbours.

#include <superray/core/ray_bundle.h>

#include <vector>

namespace superray {

/// Per ray from the common origin, in single precision. Slopes are off the exact
/// ones by less than kSlopeMargin.
template <int Dim>
struct RayDirections {
    /// Kind: dominant axis, + 4 * (bit a: axis a runs backwards); kLone if single
    /// precision cannot tell for certain.
    std::vector<std::uint32_t> kind;
    std::vector<float> length;          ///< along the dominant axis [cells]
    std::vector<float> slope[Dim - 1];  ///< minor / dominant, by ascending axis

    static constexpr std::uint32_t kLone = 32;
    static constexpr float kLeastLength = 1.0f / 64;  ///< [cells]
    static constexpr float kLeastExtent = 1.0f / (1 << 24);
    static constexpr float kCertain = 1 - 1.0f / (1 << 19);  ///< slopes below are minor
    static constexpr double kSlopeMargin = 1.0 / (1 << 20);

    void resize(std::size_t n) {
        kind.resize(n);
        length.resize(n);
        for (auto& s : slope) s.resize(n);
    }
};

/// Of the rays [begin, end). \pre out.resize(rays.size()) was called
template <int Dim>
using FindDirections = void (*)(const RayBundle<Dim>& rays, std::size_t begin, std::size_t end,
                                RayDirections<Dim>& out);

}  // namespace superray
