// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Directions and end cells of rays, as one loop without branches: plain C++
// that the compiler turns into vector instructions.

#include "directions/classified_batch.h"
#include "kernels/simd/lanes.h"

#include <cstring>

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

/// The same floor as CellGeometry::cellOf(), whose cells fit 32 bits.
template <typename Simd>
SUPERRAY_INLINE std::int32_t floorToCell(double scaled) {
    if constexpr (Simd::kHasFloor) return static_cast<std::int32_t>(__builtin_floor(scaled));
    const auto truncated = static_cast<std::int32_t>(scaled);
    return truncated - (scaled < static_cast<double>(truncated) ? 1 : 0);
}

SUPERRAY_INLINE std::uint32_t signBit(float x) {
    std::uint32_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    return bits >> 31;
}

/// A ray from the common origin, per axis.
template <int Dim>
struct RayExtent {
    float distance[Dim];      ///< of the end point from the origin [cells], without a
                              ///< sign
    std::int32_t cells[Dim];  ///< of the end cell from the sensor's cell, without a sign
    std::uint32_t flips;      ///< bit 2 + a: axis a runs backwards
    std::int32_t block,
        local;  ///< the end cell's block in the directory, its index in it
};

/// Where a ray goes: its sector and sub-bin, unless single precision cannot
/// tell.
struct RaySector {
    std::uint32_t sector, binInSector, subBinInBin;
    std::uint32_t uncertain;  ///< 0 if sector and bins are certain
    std::int32_t lastSlice;
};

/// What all rays of a scan have in common.
template <typename Simd, int Dim, typename Scalar>
struct RayClassifier {
    using Batch = ClassifiedBatch<Dim>;
    static constexpr int kAxisBits = DirectionBins<Dim>::kAxisSubBinBits;
    static constexpr std::int32_t kAxisSubBins = DirectionBins<Dim>::kAxisSubBins;

    const Scalar* coordinates[Dim];
    double origin[Dim], inverse;
    std::int32_t strides[Dim], lowest = 0;
    Cell<Dim> sensor;
    int levels;
    float subBinsPerAxis;
    std::int32_t lastSubBin;

    SUPERRAY_INLINE RayClassifier(const RayBundle<Dim>& rays, std::size_t first,
                                  const BlockDirectory<Dim>& directory, int binLevels)
        : inverse(rays.geometry().scaled(1.0)),
          sensor(rays.geometry().cellOf(rays.commonOrigin())),
          levels(binLevels),
          subBinsPerAxis(static_cast<float>(kAxisSubBins << levels)),
          lastSubBin((kAxisSubBins << levels) - 1) {
        for (int a = 0; a < Dim; ++a) {
            coordinates[a] = rays.template ends<Scalar>(a) + first;
            origin[a] = rays.geometry().scaled(rays.commonOrigin()[a]);
            // Of directories that are not dense, strides and indices mean nothing.
            strides[a] = directory.dense() ? static_cast<std::int32_t>(directory.stride(a)) : 0;
            lowest += directory.box().lo[a] * strides[a];
        }
    }

    SUPERRAY_INLINE RayExtent<Dim> extentOf(std::size_t i) const {
        RayExtent<Dim> ray;
        ray.flips = 0;
        ray.block = -lowest;
        ray.local = 0;
        for (int a = 0; a < Dim; ++a) {
            const double scaled = static_cast<double>(coordinates[a][i]) * inverse;
            const auto d = static_cast<float>(scaled - origin[a]);
            ray.distance[a] = __builtin_fabsf(d);
            // The sign bit is d < 0, but for -0.0, and rays without extent are
            // unclassified.
            ray.flips |= signBit(d) << (2 + a);
            const std::int32_t cell = floorToCell<Simd>(scaled);
            ray.block += (cell >> kBlockBits) * strides[a];
            ray.local |= (cell & (kBlockEdge - 1)) << (kBlockBits * a);
            const std::int32_t away = cell - sensor[a];
            ray.cells[a] = away < 0 ? -away : away;
        }
        return ray;
    }

    /// Example in 2D with 4 bins per axis, each of 4 sub-bins: 8 cells along x
    /// and 3 back along y have the sector 0 + (4 << 1) = 8 and the slope 3/8:
    /// sub-bin 3/8 * 16 = 6 of the sector, which is sub-bin 2 of bin 1.
    SUPERRAY_INLINE RaySector sectorOf(const RayExtent<Dim>& ray) const {
        std::uint32_t major = 0;
        float length = ray.distance[0], least = ray.distance[0];
        std::int32_t slice = ray.cells[0];
        for (int a = 1; a < Dim; ++a) {
            const bool longer = ray.distance[a] > length;
            major = longer ? static_cast<std::uint32_t>(a) : major;
            length = longer ? ray.distance[a] : length;
            slice = longer ? ray.cells[a] : slice;
            least = ray.distance[a] < least ? ray.distance[a] : least;
        }
        // Minor axes in ascending order.
        const float minor0 = major == 0 ? ray.distance[1] : ray.distance[0];
        const float minor1 = Dim == 2           ? minor0
                             : major == Dim - 1 ? ray.distance[Dim - 2]
                                                : ray.distance[Dim - 1];
        const float perLength = 1.0f / (length > 1e-30f ? length : 1e-30f);
        const float slope0 = minor0 * perLength;
        const float slope1 = minor1 * perLength;
        const float steepest = slope0 > slope1 ? slope0 : slope1;
        const std::uint32_t uncertain =
            static_cast<std::uint32_t>(least < Batch::kLeastDistance) |
            static_cast<std::uint32_t>(length < Batch::kLeastLength) |
            static_cast<std::uint32_t>(length > Batch::kGreatestLength) |
            static_cast<std::uint32_t>(steepest > Batch::kCertain);
        const std::int32_t subBin0 = subBinOf(slope0), subBin1 = subBinOf(slope1);
        std::int32_t bin = subBin0 >> kAxisBits, subBin = subBin0 & (kAxisSubBins - 1);
        if (Dim == 3) {
            bin |= subBin1 >> kAxisBits << levels;
            subBin |= (subBin1 & (kAxisSubBins - 1)) << kAxisBits;
        }
        return {major | ray.flips, static_cast<std::uint32_t>(bin),
                static_cast<std::uint32_t>(subBin), uncertain, slice};
    }
    /// Along one minor axis. Scaling by a power of two is exact, so it is that of
    /// the slope.
    SUPERRAY_INLINE std::int32_t subBinOf(float slope) const {
        const auto at = static_cast<std::int32_t>(slope * subBinsPerAxis);
        return at < lastSubBin ? at : lastSubBin;
    }
};

template <typename Simd, int Dim, typename Scalar>
void classifyRaysOf(const RayBundle<Dim>& rays, std::size_t first, std::size_t count,
                    const BlockDirectory<Dim>& directory, const DirectionBins<Dim>& bins,
                    std::uint32_t* subBinOf, std::uint16_t* lastSlice,
                    ClassifiedBatch<Dim>& out) {
    const RayClassifier<Simd, Dim, Scalar> classifier(rays, first, directory, bins.levels);
    const std::uint32_t perSector = bins.perSector();
    const std::uint32_t unclassified = bins.unclassified();
    const std::uint32_t unclassifiedSubBin = bins.firstSubBin(unclassified);
    CellOffset* const endOffsets = out.endOffset.data();
    std::uint32_t* const blocks = out.block.data();
    std::uint16_t* const locals = out.local.data();
    std::uint32_t sectors = 0;
    SUPERRAY_INDEPENDENT_ITERATIONS
    for (std::size_t i = 0; i < count; ++i) {
        const RayExtent<Dim> ray = classifier.extentOf(i);
        const RaySector to = classifier.sectorOf(ray);
        sectors |= to.uncertain != 0 ? 0u : 1u << to.sector;
        const std::uint32_t bin = to.sector * perSector + to.binInSector;
        subBinOf[i] =
            to.uncertain != 0 ? unclassifiedSubBin : bins.firstSubBin(bin) | to.subBinInBin;
        lastSlice[i] =
            static_cast<std::uint16_t>(to.lastSlice < 0xFFFF ? to.lastSlice : 0xFFFF);
        std::uint64_t packed = 0;
        for (int a = 0; a < Dim; ++a)
            packed |= std::uint64_t{static_cast<std::uint32_t>(ray.cells[a])}
                      << (CellOffset::kBits * a);
        endOffsets[i] = CellOffset(packed);
        blocks[i] = static_cast<std::uint32_t>(ray.block);
        locals[i] = static_cast<std::uint16_t>(ray.local);
    }
    out.sectors = sectors;
    out.unclassified = unclassified;
    out.subBin = subBinOf;
}

/// As ClassifyRays.
template <typename Simd, int Dim>
void classifyRays(const RayBundle<Dim>& rays, std::size_t first, std::size_t count,
                  const BlockDirectory<Dim>& directory, const DirectionBins<Dim>& bins,
                  std::uint32_t* subBinOf, std::uint16_t* lastSlice,
                  ClassifiedBatch<Dim>& out) {
    const auto classify = rays.singlePrecision() ? classifyRaysOf<Simd, Dim, float>
                                                 : classifyRaysOf<Simd, Dim, double>;
    classify(rays, first, count, directory, bins, subBinOf, lastSlice, out);
}

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
