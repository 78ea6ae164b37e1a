// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file kitti_files.h
/// Files of the KITTI benchmarks, and of data sets that follow them.

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPose3D.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace superray {

/// True if the first line with data has 12 numbers.
bool isKittiPoses(const std::string& path);
/// Poses of 12 columns a line, in the frames that they are written in.
/// \throws InputError
std::vector<mrpt::poses::CPose3D> readKittiPoses(const std::string& path);

/// The .bin files of a folder by frame number, which is their name: the row of poses and times.
/// \throws InputError if one has another name, or two have one number
std::map<std::size_t, std::filesystem::path> scansByFrame(const std::filesystem::path& folder);

/// Points of 4 floats, x y z reflectance. \throws InputError
mrpt::maps::CSimplePointsMap::Ptr readKittiPoints(const std::filesystem::path& path);

}  // namespace superray
