// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file pose_noise.h
/// Scans as a robot inserts them that does not know exactly where it is.

#include <superray/eval/point_scan.h>

#include <cstdint>
#include <vector>

namespace superray {

/// Sigmas of each scan's own error; see SeededRandom::bell() for the distribution.
struct PoseNoise {
    double metres = 0;   ///< along each axis
    double degrees = 0;  ///< about each axis
    bool none() const { return metres == 0 && degrees == 0; }
    /// \throws InputError unless both are finite and >= 0
    void validate() const;
};

/// Moves and turns each scan about its origin.
void addPoseNoise(std::vector<PointScan>& scans, const PoseNoise& noise, std::uint64_t seed);

}  // namespace superray
