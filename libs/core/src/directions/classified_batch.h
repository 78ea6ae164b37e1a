// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Direction and end of each ray of a batch, and the directions that there are.

#include <superray/core/ray_bundle.h>

#include "counting/block_directory.h"
#include "directions/first_unsettled.h"
#include "directions/packed_triple.h"

#include <array>

namespace superray {

/// Cells from the sensor's cell, per axis, without a sign: the ray's sector has the signs.
using CellOffset = PackedTriple;

/// Ids of directions, as seen from the common origin of a scan.
///
///   sector    major axis + 4 * (bit a: the ray runs backwards along axis a)
///   bin       square (in 2D, stretch) of slopes minor / major, 0 .. 1 per minor axis:
///             sector * perSector() + index. The 2^levels bins per minor axis are followed by
///             those of coarser levels, each half as many per axis, down to one bin
///   sub-bin   16 * bin + one of the 4 * 4 parts of the bin (in 2D, 4 parts, each four times)
template <int Dim>
struct DirectionBins {
    static constexpr std::uint32_t kSectors = 1u << (2 + Dim);
    static constexpr int kMostLevels = Dim == 2 ? 12 : 6;

    static constexpr int kSubBinBits = 4;
    static_assert(1 << kSubBinBits == FirstUnsettled::kSubBins);
    static constexpr int kAxisSubBinBits = 2;
    static constexpr int kAxisSubBins = 1 << kAxisSubBinBits;  ///< of a bin, per minor axis

    int levels = 0;  ///< 2^levels bins per minor axis

    static constexpr std::uint32_t binOf(std::uint32_t subBin) { return subBin >> kSubBinBits; }
    static constexpr std::uint32_t firstSubBin(std::uint32_t bin) { return bin << kSubBinBits; }

    std::uint32_t edge(int level) const { return 1u << (levels - level); }
    /// Index of a level's first bin, from the sector's first.
    std::uint32_t levelBegin(int level) const {
        std::uint32_t begin = 0;
        for (int l = 0; l < level; ++l) begin += 1u << ((Dim - 1) * (levels - l));
        return begin;
    }
    /// Bins from one sector to the next: a power of two, to find the sector of a sub-bin
    /// by a shift.
    int perSectorBits() const { return (Dim - 1) * levels + 1; }
    std::uint32_t perSector() const { return 1u << perSectorBits(); }
    static constexpr std::uint32_t majorAxisOf(std::uint32_t sector) { return sector & 3; }
    std::uint32_t sectorOf(std::uint32_t subBin) const {
        return subBin >> (perSectorBits() + kSubBinBits);
    }
    /// Bin of rays whose sector is not certain in single precision.
    std::uint32_t unclassified() const { return kSectors * perSector(); }
    /// Bin of rays that were walked early.
    std::uint32_t finished() const { return unclassified() + 1; }
    std::uint32_t count() const { return finished() + 1; }
};

/// Up to kMost rays in a row, as classified: their directions and end cells.
template <int Dim>
struct ClassifiedBatch {
    static constexpr std::size_t kMost = 1024;  ///< rays: as many as the L1 cache holds
    static constexpr std::size_t kSlack = 16;   ///< what vector loads may read beyond

    static constexpr float kLeastLength = 1.0f / 64;  ///< [cells]
    /// Slices of longer rays might not fit the ranges's 16 bits [cells].
    static constexpr float kGreatestLength = 65000;
    static constexpr float kLeastDistance = 1.0f / (1 << 24);
    static constexpr float kCertain = 1 - 1.0f / (1 << 19);  ///< slopes below are minor
    /// SubBins are those of slopes in single precision, off the exact ones by less.
    static constexpr double kSlopeMargin = 1.0 / (1 << 20);

    const std::uint32_t* subBin;  ///< per ray; of unclassified rays: the first one
    std::array<CellOffset, kMost + kSlack> endOffset;  ///< of the end cell
    std::array<std::uint32_t, kMost> block;  ///< BlockDirectory::indexOf(), if it is dense
    std::array<std::uint16_t, kMost> local;  ///< index of the end cell in its block
    std::uint32_t sectors;                   ///< bit k: there are rays of sector k
    std::uint32_t unclassified;              ///< DirectionBins::unclassified()
};

/// Of `count` rays from `first` on.
/// \param directory covers the scan
/// \param subBin of each ray, with kSlack more
/// \param lastSlice of each ray: in which it ends (of unclassified rays, any)
/// \pre count <= ClassifiedBatch::kMost
template <int Dim>
using ClassifyRays = void (*)(const RayBundle<Dim>& rays, std::size_t first, std::size_t count,
                              const BlockDirectory<Dim>& directory,
                              const DirectionBins<Dim>& bins, std::uint32_t* subBin,
                              std::uint16_t* lastSlice, ClassifiedBatch<Dim>& out);

/// Finds runs of rays that go and end alike among the first `count` rays: where they
/// begin. Unclassified rays are runs of their own, for they may go opposite ways.
/// \param starts has room for kSlack more than there are rays
/// \return number of runs
template <int Dim>
using FindRuns = std::size_t (*)(const ClassifiedBatch<Dim>& directions, const RayEnd* ends,
                                 std::size_t count, std::uint32_t* starts);

/// Chooses among `count` rays those of open sub-bins whose last slice is not before the
/// first open one of their bin, in order.
/// \param lastSlice of each ray, with kSlack more
/// \param unsettled of each bin
/// \param chosen has room for kSlack more than there are rays
/// \return number of rays chosen
using ChooseRays = std::size_t (*)(const std::uint32_t* subBin, const std::uint16_t* lastSlice,
                                   std::size_t count, const FirstUnsettled* unsettled,
                                   std::uint32_t* chosen);

}  // namespace superray
