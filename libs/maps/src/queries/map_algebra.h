// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_algebra.h
/// Parts of maps, and maps made of two.

#include <mrpt/poses/CPose3D.h>
#include <superray/maps/map_queries.h>
#include <superray/storage/occupancy_map.h>

#include <array>
#include <vector>

namespace superray {

/// Copies the cells whose centres lie in the box (borders included; 2D: z is not
/// looked at) to an empty map. \throws std::invalid_argument unless lowest <= highest
template <int Dim>
void copyBox(const OccupancyMap<Dim>& from, const MetricBounds& box, OccupancyMap<Dim>& to);

/// New contents of one block.
template <int Dim>
struct MergedBlock {
    BlockKey<Dim> key;
    BlockMask<Dim> known;  ///< cells that `from` knows
    std::array<float, kBlockCells<Dim>> values;
};

/// What adding the log-odds of `from`, which lies at T_to_from, makes of `to`: each
/// cell of `to` gets the value of the cell of `from` that its centre lies in.
/// Values are clamped as the model says. Nothing is written.
/// \throws std::invalid_argument if cells would leave the addressable range, or (2D)
///         if the pose is not planar
template <int Dim>
std::vector<MergedBlock<Dim>> mergedBlocks(const OccupancyMap<Dim>& to,
                                           const OccupancyMap<Dim>& from,
                                           const mrpt::poses::CPose3D& T_to_from,
                                           const SensorModel& model);

}  // namespace superray
