// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file cloud_files.h
/// Point clouds in files: PCD and PLY.

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPose3D.h>

#include <optional>
#include <string>

namespace superray {

struct CloudFile {
    mrpt::maps::CSimplePointsMap::Ptr points;  ///< [m]
    /// Where the sensor was, if the file says (PCD's VIEWPOINT other than the origin).
    std::optional<mrpt::poses::CPose3D> viewpoint;
};

/// PCD of the Point Cloud Library, version 0.7 and before: ascii, binary, or
/// binary_compressed; fields x, y, z of any type, others are skipped.
/// \throws InputError naming file and rule; also for files that end early
CloudFile readPcd(const std::string& path);

/// PLY: ascii, or binary of either byte order; element vertex with x, y, z of any type.
/// \throws InputError likewise
CloudFile readPly(const std::string& path);

}  // namespace superray
