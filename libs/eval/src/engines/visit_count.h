// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file visit_count.h
/// What walking a scan visits, counted independently of the engine.

#include <superray/core/scan_integrator.h>
#include <superray/eval/point_scan.h>

namespace superray {

struct VisitCount {
    std::uint64_t all = 0;  ///< cells before the end cell, over all rays
    /// Of those, the ones that a miss may change: not saturated free or, under netEvidence,
    /// hit by the scan.
    std::uint64_t changeable = 0;
    /// The same with every super ray walked once.
    std::uint64_t changeableOfSuperRays = 0;
};

/// \param map before the scan, with the default probabilities of the policy
VisitCount countVisits(const PointScan& scan, double resolution, UpdatePolicy policy,
                       std::uint32_t superRayThreshold, const SaturationSource<3>& map);

}  // namespace superray
