// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file pose_options.h
/// Options of how recordings are read: --poses, --fixed-robot, --pose-source, --pose-label,
/// --max-pose-gap, --intrinsics, --depth-units.

#include <superray/eval/scan_source.h>

#include <CLI/CLI.hpp>
#include <string>

namespace superray {

/// What becomes ScanSourceOptions::poses.
struct PoseArguments {
    std::string source;
    bool fixedRobot = false;
};

void addPoseOptions(CLI::App& app, PoseArguments& arguments, ScanSourceOptions& source);

/// --intrinsics and --depth-units.
void addDepthCameraOptions(CLI::App& app, ScanSourceOptions& source);

/// \throws std::exception if they contradict each other
PoseOrigin poseOrigin(const PoseArguments& arguments, const ScanSourceOptions& source);

}  // namespace superray
