// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file octomap_input.h
/// Reads OctoMap's .ot and .bt files into cells, trusting nothing in them
/// (OctoMap's own readers follow a damaged file into a stack overflow).

#include <superray/storage/map_file_error.h>
#include <superray/storage/occupancy_map.h>

#include <cstdint>
#include <memory>
#include <string>

namespace superray {

/// What the values of a file mean.
enum class CellValues : std::uint8_t {
    logOdds,    ///< .ot, .srmap: float32 log-odds
    occupancy,  ///< .bt: only occupied (stored here as +1) or free (-1)
};

struct OctomapFile {
    CellValues values = CellValues::logOdds;
    std::unique_ptr<OccupancyMap<3>> map;
    std::string note;  ///< what of the file was left out (colours); else empty
};

/// What a file may ask for. A few bytes can stand for 2^48 cells: of a file that its
/// size does not account for, cells are refused before they are made. With
/// SUPERRAY_MAP_MEGABYTES, as many as have room in that are read of any file, up to `cells`.
struct OctomapLimits {
    std::uint64_t fileBytes = std::uint64_t{4} << 30;
    std::uint64_t cells = 1'000'000'000;
    std::uint64_t cellsOfAnyFile = std::uint64_t{1} << 24;
    std::uint64_t cellsPerByte = 1024;
};

/// True if the file begins as OctoMap's trees do, whatever its name.
bool isOctomapFile(const std::string& path);

/// Reads an OcTree or ColorOcTree file; which of the two formats is told by its first
/// line. Pruned leaves become all the cells that they stand for.
/// \throws MapFileError naming the file and what is wrong: not such a tree, truncated,
///         deeper than 16 levels, not the announced size, more than the limits
OctomapFile loadOctomapFile(const std::string& path, const OctomapLimits& limits = {});

}  // namespace superray
