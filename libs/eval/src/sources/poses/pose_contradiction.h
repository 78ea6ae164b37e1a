// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file pose_contradiction.h
/// Poses of one time that cannot all be true.

#include <string>

#include "sources/poses/pose_streams.h"

namespace superray {

/// Whether there are several times, and at least half as many as poses.
bool mostTimesDiffer(const PoseStream& stream);

/// Poses of one time may differ a little: clocks have ticks. Not by more than 0.1 m or
/// 0.1 rad and twice the way from the time before to the time after.
/// \throws InputError, naming `what` and the time
void requireOnePoseATime(const PoseStream& stream, const std::string& what);

}  // namespace superray
