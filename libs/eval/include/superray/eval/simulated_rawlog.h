// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file simulated_rawlog.h
/// Simulated worlds as recordings for any MRPT program.

#include <superray/eval/progress_meter.h>
#include <superray/eval/simulated_world.h>

#include <cstdint>
#include <string>

namespace superray {

/// Writes the first `scans` scans (all, if there are fewer): per scan a
/// CObservationRobotPose (label POSE) and a CObservationPointCloud (label
/// SIMULATED) of the same time. Beside it, `<name>.tum` has the true robot
/// poses: `t x y z qx qy qz qw`. Each of them is written whole or not
/// at all.
/// \param path ends in .rawlog
/// \throws MapFileError if they cannot be written
void writeSimulatedRawlog(const SimulatedWorld& world, std::uint64_t scans,
                          const std::string& path, const LoadProgress& progress = {});

}  // namespace superray
