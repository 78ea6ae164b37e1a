// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file scan_character.h
/// What kind of scans these are: the numbers that decide which engine is fast.

#include <superray/eval/point_scan.h>

#include <cstdint>
#include <string>
#include <vector>

namespace superray {

/// Means over scans, at one resolution.
struct ScanCharacter {
    std::size_t scans = 0;
    double points = 0;         ///< per scan
    double meanRange = 0;      ///< [m]
    double largestRange = 0;   ///< [m], of all scans
    double rayCells = 0;       ///< cells before the end cells, over all rays, per scan
    double distinctCells = 0;  ///< of those, different ones, per scan
    double endCells = 0;       ///< different end cells, per scan
    std::uint64_t blocks = 0;  ///< 8^3 blocks touched by any scan
};

/// \param resolution [m]
ScanCharacter characterOf(const std::vector<PointScan>& scans, double resolution);

/// Lines of text.
std::string describe(const ScanCharacter& character);

}  // namespace superray
