// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file slam_output.h
/// Writing what SLAM has made: whole files or none.

#include <mrpt/opengl/opengl_frwds.h>
#include <superray/slam/range_slam.h>

#include <memory>
#include <string>

namespace superray {

/// Checks, before long work, that a file could be written at `path`.
/// \throws InputError
void checkSlamOutputPath(const std::string& path);

/// Writes by extension: .tum (trajectory), .srmap (map), .simplemap (key frames:
/// poses with observations, for MRPT's programs), .3Dscene (map and trajectory).
/// \throws InputError, std::exception if it cannot be written
void writeSlamOutput(const RangeSlam& slam, const std::string& path);

/// The trajectory as a line, with the axes of its last pose.
std::shared_ptr<mrpt::opengl::CSetOfObjects> makeTrajectoryView(const Trajectory& trajectory);

}  // namespace superray
