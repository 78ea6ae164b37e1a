// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file accuracy.h
/// How true the maps of engines are: against held-out points, and against the geometry
/// of simulated worlds.

#include <mrpt/img/CImage.h>
#include <superray/eval/accuracy_score.h>
#include <superray/eval/bench_engine.h>
#include <superray/eval/moving_score.h>
#include <superray/eval/pose_noise.h>
#include <superray/eval/progress_meter.h>
#include <superray/eval/test_points.h>
#include <superray/eval/world_truth.h>

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace superray {

/// Heights from `low` to `high` [m, map frame].
struct Slice {
    double low, high;
};

struct AccuracyRequest {
    std::vector<std::string> data;  ///< see PointScanRequest
    ScanSourceOptions source;
    std::uint64_t worldSeed = 1;
    std::vector<double> resolutions = {0.2};  ///< [m]
    std::vector<std::string> engines = {"grid", "octomap", "mrpt-grid3d"};
    /// Of our maps; each policy has its own probabilities.
    std::vector<UpdatePolicy> policies = {UpdatePolicy::netEvidence, UpdatePolicy::everyRay,
                                          UpdatePolicy::oncePerScan};
    /// Of our maps with netEvidence: one row each; empty: the default.
    std::vector<double> scanMissMins;
    std::vector<PeerModel> peerModels = {PeerModel::shared, PeerModel::own};
    unsigned threads = 1;
    PoseNoise poseNoise;         ///< of the scans that maps are made of
    double testShare = 0.2;      ///< in (0, 1): of the points of each scan
    std::uint64_t testSeed = 1;  ///< of the choice of test points, and of the pose noise
    bool pictures = false;       ///< draw AccuracyTable::picture
    /// What pictures show; nothing: one layer of cells, half a metre below the sensor of
    /// the first scan.
    std::optional<Slice> slice;
    /// \throws InputError, std::invalid_argument
    void validate() const;
};

/// Points of a range, or of an incidence, [from, to).
struct AccuracyBand {
    double from, to;
    ClassScore occupied, free;
};

/// One map.
struct AccuracyRow {
    std::string engine;
    std::string policy;   ///< "netEvidence 0.4": with that scanMissMin
    std::string model;    ///< of peers: "shared", "own", or "shared = own"; else "-"
    std::string weights;  ///< what its probabilities really come to, a line of text
    AccuracyScore score;
    std::vector<AccuracyBand> byRange;      ///< [m] from the sensor to the tested point
    std::vector<AccuracyBand> byIncidence;  ///< [degrees]; occupied points, worlds only
    std::optional<TruthScore> truth;        ///< of worlds that do not change
    std::optional<MovingScore> moving;      ///< of worlds with moving things
};

/// All maps of one input at one resolution. Of worlds with moving things, rows have
/// `moving` alone.
struct AccuracyTable {
    std::string data;
    double resolution = 0;  ///< [m]
    std::uint64_t scans = 0, points = 0;
    std::vector<AccuracyRow> rows;
    std::optional<mrpt::img::CImage> picture;
};

/// Runs everything, one map after the other.
/// \throws InputError
std::vector<AccuracyTable> runAccuracy(const AccuracyRequest& request, std::ostream& log,
                                       ProgressMeter::Style style);

/// \param tables of `request`
std::string accuracyAsText(const AccuracyRequest& request,
                           const std::vector<AccuracyTable>& tables);
std::string accuracyAsJson(const AccuracyRequest& request,
                           const std::vector<AccuracyTable>& tables);

}  // namespace superray
