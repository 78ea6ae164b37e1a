// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file cloud_files.h
/// Point clouds in files: PCD, PLY and LAS. All readers throw InputError, which names file and
/// rule, also for files that end early; and FarCoordinate.

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPose3D.h>

#include <optional>
#include <string>

namespace superray {

/// Points [m] of a PCD file of the Point Cloud Library, version 0.7 and before: ascii, binary,
/// or binary_compressed; fields x, y, z of any type, others are skipped.
mrpt::maps::CSimplePointsMap::Ptr readPcd(const std::string& path);

/// Where the sensor was, as the header of a PCD file says: its VIEWPOINT, if that is other
/// than the origin. Reads no more than the start of the file.
/// \throws InputError
std::optional<mrpt::poses::CPose3D> readPcdViewpoint(const std::string& path);

/// Points of a PLY file: ascii, or binary of either byte order; element vertex with x, y, z of
/// any type.
mrpt::maps::CSimplePointsMap::Ptr readPly(const std::string& path);

/// Points of a LAS file, versions 1.0 to 1.4, point formats 0 to 10; points that are flagged
/// as withheld (deleted) are left out.
/// \throws InputError also if the box in the header does not hold the points
mrpt::maps::CSimplePointsMap::Ptr readLas(const std::string& path);

/// The error of compressed LAS, which no library that all releases have reads.
[[noreturn]] void throwIsLaz(const std::string& path);

}  // namespace superray
