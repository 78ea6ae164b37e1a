// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file realtime.h
/// Navigation as in Sec. V-B of the paper: scans come at the sensor's rate, and
/// those that come while the map is being updated are lost.

#include <superray/eval/accuracy_score.h>
#include <superray/eval/bench_engine.h>
#include <superray/eval/progress_meter.h>
#include <superray/eval/test_points.h>

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace superray {

struct RealtimeRequest {
    std::string data;  ///< see PointScanRequest
    ScanSourceOptions source;
    std::uint64_t worldSeed = 1;
    double rate = 10;         ///< scans a second, > 0
    double resolution = 0.2;  ///< [m]
    std::vector<std::string> engines;
    std::vector<unsigned> threads = {1};
    UpdatePolicy policy = UpdatePolicy::netEvidence;
    PeerModel peerModel = PeerModel::shared;
    TrainingPoints training = TrainingPoints::share;
    /// [MB] that our maps take before the first scan, as a robot's would; see
    /// TCreationOptions::reserve_megabytes.
    std::uint32_t reserveMegabytes = 256;
    double testShare = 0.2;      ///< in (0, 1): of the points of each scan
    std::uint64_t testSeed = 1;  ///< of the choice of test points
    SplitOptions split() const { return {resolution, training, testShare, testSeed}; }
    /// \throws InputError, std::invalid_argument
    void validate() const;
};

struct RealtimeRun {
    std::string engine;
    std::string weights;  ///< what its probabilities really come to, a line of text
    unsigned threads = 1;
    std::uint64_t scansUsed = 0, scansLost = 0;
    std::vector<double> updateMs;  ///< elapsed time of each scan used
    ClassScore occupied;           ///< at end points of test rays
    ClassScore free;               ///< at points drawn along test rays
    ClassScore all() const {
        ClassScore sum = occupied;
        return sum += free;
    }
};

/// Which scans are used, if they arrive at `rate` a second and each one used
/// keeps the map busy for the time that `update(i)` returns [s].
/// \return their numbers
std::vector<std::size_t> replayAtRate(std::size_t scans, double rate,
                                      const std::function<double(std::size_t)>& update);

/// Runs the engines one after the other. The clock is simulated: the measured
/// time of an update decides which scans are lost, and nobody waits.
std::vector<RealtimeRun> runRealtime(const RealtimeRequest& request, std::ostream& log,
                                     ProgressMeter::Style style);

std::string realtimeAsText(const RealtimeRequest& request,
                           const std::vector<RealtimeRun>& runs);
std::string realtimeAsJson(const RealtimeRequest& request,
                           const std::vector<RealtimeRun>& runs);

}  // namespace superray
