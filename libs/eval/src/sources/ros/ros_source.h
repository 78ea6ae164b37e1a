// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file ros_source.h
/// Scans and poses of ROS recordings.

#include <superray/eval/scan_source.h>

#include <memory>
#include <string>

namespace superray {

/// A recording that openRosRecording() reads. Sensors are labelled by their topics. See
/// chooseRobotFrame() for the robot's frame, and robotPoses() for its poses. \throws InputError
std::unique_ptr<ScanSource> openRos(const std::string& path, const ScanSourceOptions& options);

}  // namespace superray
