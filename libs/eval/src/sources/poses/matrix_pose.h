// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file matrix_pose.h
/// Poses that texts give as matrices.

#include <mrpt/poses/CPose3D.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace superray {

/// A 3x4 matrix in row-major order, as KITTI and MulRan write poses and calibrations.
/// \throws InputError naming `where`: not 12 numbers, or no rotation (a mirror is none)
Eigen::Isometry3d fromRowMajor(const std::vector<double>& values, const std::string& where);

mrpt::poses::CPose3D toPose(const Eigen::Isometry3d& T);

}  // namespace superray
