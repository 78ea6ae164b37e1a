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

/// Rays of a group: what is walked side by side.
inline constexpr std::size_t kGroupRays = 8;

/// Bounds of groups of kGroupRays consecutive rays.
template <int Dim>
struct GroupBounds {
    static constexpr std::size_t kGroups = 8;  ///< that are bounded at once
    /// Per group: bounds of slopes, and the largest extent along each minor axis.
    float low[Dim - 1][kGroups], high[Dim - 1][kGroups], reach[Dim - 1][kGroups];
    float length[kGroups];  ///< largest
    std::uint32_t lowestKind[kGroups], highestKind[kGroups];
};

/// Of the groups that begin with the ray `first`.
/// \pre there are kGroups * kGroupRays rays from there on
template <int Dim>
using BoundGroups = void (*)(const RayDirections<Dim>& directions, std::size_t first,
                             GroupBounds<Dim>& out);

}  // namespace superray
