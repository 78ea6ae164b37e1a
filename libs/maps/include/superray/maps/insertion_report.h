// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file insertion_report.h
/// What inserting scans did, how long it took, and what was left out and why.

#include <superray/core/ray_bundle.h>
#include <superray/core/scan_integrator.h>

#include <cstdint>

namespace superray {

/// One scan, or the sum over many.
struct TInsertionReport {
    std::uint64_t scans = 0;  ///< observations that changed the map
    std::uint64_t rays = 0;   ///< rays inserted
    SkippedPoints skipped;    ///< returns that could not become rays
    /// Measurements without a return, or out of the sensor's own range limits
    /// (they are rays too if insertNoReturnRays is set).
    std::uint64_t noReturns = 0;
    /// Returns outside heightBandMin..Max. (In 2D maps those of 3D sensors still clear.)
    std::uint64_t outOfHeightBand = 0;
    std::uint64_t tilted = 0;       ///< rays of planar scanners beyond horizontalTolerance (2D)
    std::uint64_t withoutPose = 0;  ///< rays measured when no robot pose is known
    /// Rays whose sensor tells when they were measured (with insertObservationAlong()).
    std::uint64_t timedRays = 0;
    std::uint64_t forgottenBlocks = 0;  ///< blocks that windowRadius made unknown again
    ScanStatistics work;                ///< zero where method = reference
    double toRaysSeconds = 0;           ///< observation to rays
    double integrateSeconds = 0;        ///< rays to update batch
    double applySeconds = 0;            ///< update batch to map

    TInsertionReport& operator+=(const TInsertionReport& o) {
        scans += o.scans;
        rays += o.rays;
        skipped += o.skipped;
        noReturns += o.noReturns;
        outOfHeightBand += o.outOfHeightBand;
        tilted += o.tilted;
        withoutPose += o.withoutPose;
        timedRays += o.timedRays;
        forgottenBlocks += o.forgottenBlocks;
        work += o.work;
        toRaysSeconds += o.toRaysSeconds;
        integrateSeconds += o.integrateSeconds;
        applySeconds += o.applySeconds;
        return *this;
    }
};

}  // namespace superray
