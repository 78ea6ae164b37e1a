// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file coarse_levels.h

#include <superray/maps/map_queries.h>
#include <superray/storage/occupancy_map.h>

#include <optional>

namespace superray {

inline constexpr unsigned kCoarsestLevel = 16;
inline constexpr std::uint64_t kCubeBlocks = 4096;

/// Log-odds of the aligned cube of 2^level cells per axis that holds `cell`;
/// nothing if it has no known cell. The work is that of its blocks; for cubes of
/// more than kCubeBlocks blocks that of the whole map.
/// \throws std::invalid_argument if level > kCoarsestLevel
template <int Dim>
std::optional<float> logOddsAtLevel(const OccupancyMap<Dim>& map, const Cell<Dim>& cell,
                                    unsigned level, LevelRule rule);

}  // namespace superray
