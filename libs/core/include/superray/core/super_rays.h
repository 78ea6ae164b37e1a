// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file super_rays.h
/// Super rays (paper Sec. IV-A): rays that end in the same cell and cross the
/// same cells are walked once, with a weight.

#include <superray/core/ray_bundle.h>

#include <cstdint>
#include <vector>

namespace superray {

/// `weight` rays of a bundle with the cells of ray number `ray`.
struct SuperRay {
    std::uint32_t ray;
    std::uint32_t weight;
};

/// Groups the rays of a scan with mapping lines.
///
/// Per end cell, and per plane of two axes (2D: one; 3D: XY, YZ, ZX), the grid
/// points between the rays are projected from the sensor onto a mapping line;
/// two rays are equal if they fall into the same segment of every mapping line
/// (paper Sec. IV-A1, IV-A2). The coordinate on the mapping line is the slope
/// as seen from the sensor, so it stands at unit distance.
///
/// A ray closer to a segment border than rounding can tell (the lag of the
/// digital line, see RayLine, and of this computation) stays alone, so merged
/// rays have the same cells for certain (design rule 7).
template <int Dim>
class SuperRayGrouper {
 public:
    /// \param threshold k: end cells with fewer rays are not grouped; >= 1
    /// \return super rays whose weights sum to rays.size(), valid until the
    ///         next call. Rays with origins of their own all stay alone.
    const std::vector<SuperRay>& group(const RayBundle<Dim>& rays, std::uint32_t threshold);

 private:
    /// A stretch of a mapping line whose rays cannot be told apart for certain.
    struct Border {
        double from, to;
    };
    struct Keyed {
        std::uint64_t segments;  // of all mapping lines
        std::uint32_t ray;
    };

    void bucketByEndCell(const RayBundle<Dim>& rays);
    void groupEndCell(const RayBundle<Dim>& rays, const std::uint32_t* begin,
                      const std::uint32_t* end);
    struct MappingLine;
    void divideByMappingLine(const RayBundle<Dim>& rays, const Cell<Dim>& endCell, int axisA,
                             int axisB);
    void findSlopes(const RayBundle<Dim>& rays, const MappingLine& line);
    void findBorders(const MappingLine& line);
    void mergeOverlappingBorders();
    void appendSegments();

    std::vector<SuperRay> out_;
    std::vector<std::uint32_t> table_, bucketOf_, bucketStart_, sorted_;
    std::vector<Cell<Dim>> endCells_;
    std::vector<Keyed> keyed_;
    std::vector<Border> borders_;
    std::vector<double> slopes_;
};

extern template class SuperRayGrouper<2>;
extern template class SuperRayGrouper<3>;

}  // namespace superray
