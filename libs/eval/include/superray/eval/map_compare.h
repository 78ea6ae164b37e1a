// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_compare.h
/// How two maps differ, cell by cell.

#include <superray/eval/octomap_file.h>
#include <superray/storage/occupancy_map.h>

#include <cstdint>
#include <string>

namespace superray {

/// Result of comparing map B with map A.
struct MapDifference {
    std::uint64_t cellsA = 0, cellsB = 0;  ///< known cells
    std::uint64_t missing = 0;             ///< known in A only
    std::uint64_t extra = 0;               ///< known in B only
    std::uint64_t differing = 0;           ///< known in both, with other values
    /// Largest |A - B| of a cell known in both [log-odds]; 0 if only occupancy
    /// is compared.
    double largest = 0;
    /// What was compared: bits of the log-odds, or, where a file has no more,
    /// whether cells are occupied.
    CellValues compared = CellValues::logOdds;

    bool identical() const { return missing == 0 && extra == 0 && differing == 0; }
};

/// Compares the known cells of two maps of the same geometry; log-odds are
/// equal only if all their bits are.
/// \param compared with CellValues::occupancy, a cell is occupied if its value
///        is >= the threshold of its map [log-odds]
template <int Dim>
MapDifference compareMaps(const OccupancyMap<Dim>& a, const OccupancyMap<Dim>& b,
                          CellValues compared = CellValues::logOdds, float thresholdA = 0,
                          float thresholdB = 0);

/// Compares two map files, each .srmap, .ot or .bt. A .bt file has no log-odds:
/// then occupancy is compared.
/// \throws InputError (or MapFileError) if one cannot be read, or if dimension
///         or resolution differ. OctoMap writes resolutions with 6 digits:
///         its files are believed to that precision.
MapDifference compareMapFiles(const std::string& pathA, const std::string& pathB);

/// The result in lines of text.
std::string describe(const MapDifference& difference);
/// The same as one JSON object: `identical`, `compared` ("log-odds" or "occupancy"),
/// `cells_a`, `cells_b`, `missing`, `extra`, `differing`, `largest_difference`.
std::string describeAsJson(const MapDifference& difference);

extern template MapDifference compareMaps<2>(const OccupancyMap<2>&, const OccupancyMap<2>&,
                                             CellValues, float, float);
extern template MapDifference compareMaps<3>(const OccupancyMap<3>&, const OccupancyMap<3>&,
                                             CellValues, float, float);

}  // namespace superray
