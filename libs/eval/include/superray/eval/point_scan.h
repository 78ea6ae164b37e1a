// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file point_scan.h
/// Scans as every engine of the benchmark gets them: points in the map frame.

#include <superray/eval/progress_meter.h>
#include <superray/eval/scan_source.h>
#include <superray/eval/simulated_world.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace superray {

/// Rays from one origin to end points [m, map frame]; all finite.
struct PointScan {
    Eigen::Vector3f origin;
    std::vector<Eigen::Vector3f> points;
};

/// What to load.
struct PointScanRequest {
    /// A simulated world (`indoor`, `outdoor`, `walker`), or any input of openScanSource().
    std::string data;
    ScanSourceOptions source;                 ///< of recorded inputs; maxScans also of worlds
    std::uint64_t worldSeed = 1;              ///< of simulated worlds
    RangeNoise noise = RangeNoise::measured;  ///< of simulated worlds
};

/// Scans of one input, in memory.
struct PointScans {
    std::string name;              ///< of the world, or of the file without extension
    std::vector<PointScan> scans;  ///< never empty
    std::uint64_t points = 0;      ///< in all of them
    Eigen::AlignedBox3f bounds;    ///< of all origins and points
};

/// \throws InputError as openScanSource(), or if no scan has a point
PointScans loadPointScans(const PointScanRequest& request, const LoadProgress& progress = {});

/// A recorded scan in the map frame; empty if it has no ranges or points that
/// we can use. Points that are not finite are left out.
PointScan toPointScan(const Scan& scan);

}  // namespace superray
