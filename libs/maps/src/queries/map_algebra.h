// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_algebra.h
/// Parts of maps, and maps made of two.

#include <mrpt/poses/CPose3D.h>
#include <superray/maps/map_queries.h>
#include <superray/storage/occupancy_map.h>

#include <array>
#include <cstddef>
#include <deque>
#include <functional>

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

/// A deque: it takes no more memory when it grows than it has.
template <int Dim>
using MergedBlocks = std::deque<MergedBlock<Dim>>;

/// Asked whether a merge may go on, with what has come of it so far and the memory
/// [bytes] that it works in. Throws if not.
template <int Dim>
using MergeCheck = std::function<void(const MergedBlocks<Dim>&, std::size_t)>;

/// What adding the log-odds of `from`, which lies at T_to_from, makes of `to`: each
/// cell of `to` gets the value of the cell of `from` that its centre lies in.
/// Values are clamped as the model says. Nothing is written.
/// \param check asked at the end, and each time when there is an eighth more: coarse cells
///        become very many fine ones
/// \throws std::invalid_argument if cells would leave the addressable range, or (2D)
///         if the pose is not planar; what `check` throws
template <int Dim>
MergedBlocks<Dim> mergedBlocks(const OccupancyMap<Dim>& to, const OccupancyMap<Dim>& from,
                               const mrpt::poses::CPose3D& T_to_from, const SensorModel& model,
                               const MergeCheck<Dim>& check);

}  // namespace superray
