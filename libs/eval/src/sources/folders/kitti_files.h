// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file kitti_files.h
/// Files of the KITTI benchmarks, and of data sets that follow them.

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPose3D.h>

#include <filesystem>
#include <string>
#include <vector>

namespace superray {

/// True if the first line with data has 12 numbers.
bool isKittiPoses(const std::string& path);
/// Poses of 12 columns a line, in the frames that they are written in.
/// \throws InputError
std::vector<mrpt::poses::CPose3D> readKittiPoses(const std::string& path);

/// Points of 4 floats, x y z reflectance. \throws InputError
mrpt::maps::CSimplePointsMap::Ptr readKittiPoints(const std::filesystem::path& path);

}  // namespace superray
