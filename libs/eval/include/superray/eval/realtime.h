// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file realtime.h
/// Navigation as in Sec. V-B of the paper: scans come at the sensor's rate, and
/// those that come while the map is being updated are lost.

#include <superray/eval/bench_engine.h>
#include <superray/eval/progress_meter.h>

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace superray {

/// Which points the maps are built from. Test points are the same in both.
enum class TrainingPoints : std::uint8_t {
    share,  ///< those that are not test points
    all     ///< whole scans: the time that a robot would need
};

struct RealtimeRequest {
    std::string data;  ///< see PointScanRequest
    ScanSourceOptions source;
    std::uint64_t worldSeed = 1;
    double rate = 10;         ///< scans a second, > 0
    double resolution = 0.2;  ///< [m]
    std::vector<std::string> engines;
    std::vector<unsigned> threads = {1};
    UpdatePolicy policy = UpdatePolicy::netEvidence;
    TrainingPoints training = TrainingPoints::share;
    /// [MB] that our maps take before the first scan, as a robot's would; see
    /// TCreationOptions::reserve_megabytes.
    std::uint32_t reserveMegabytes = 256;
    double testShare = 0.2;      ///< in (0, 1): of the points of each scan
    std::uint64_t testSeed = 1;  ///< of the choice of test points
    /// \throws InputError, std::invalid_argument
    void validate() const;
};

/// Agreement of a map with test points.
struct MapAccuracy {
    std::uint64_t tested = 0;   ///< points
    std::uint64_t correct = 0;  ///< p > 0.7 where occupied, p < 0.3 where free
    std::uint64_t unknown = 0;  ///< of those that are not correct
    double share() const {
        return tested == 0 ? 0 : static_cast<double>(correct) / static_cast<double>(tested);
    }
};

struct RealtimeRun {
    std::string engine;
    unsigned threads = 1;
    std::uint64_t scansUsed = 0, scansLost = 0;
    std::vector<double> updateMs;  ///< elapsed time of each scan used
    MapAccuracy occupied;          ///< at end points of test rays
    MapAccuracy free;              ///< at points drawn along test rays
    MapAccuracy all() const {
        return {occupied.tested + free.tested, occupied.correct + free.correct,
                occupied.unknown + free.unknown};
    }
};

/// Which scans are used, if they arrive at `rate` a second and each one used
/// keeps the map busy for the time that `update(i)` returns [s].
/// \return their numbers
std::vector<std::size_t> replayAtRate(std::size_t scans, double rate,
                                      const std::function<double(std::size_t)>& update);

/// A point of which the truth is taken as known.
struct TestPoint {
    Eigen::Vector3f point;
    bool occupied;
};

/// Scans parted for training and testing.
struct TrainTestSplit {
    std::vector<PointScan> training;  ///< as many as there are scans
    std::vector<TestPoint> tests;     ///< of all scans
};
/// The end points of test rays are occupied; on each test ray one free point is
/// drawn, evenly, at least two cells before the end (none on shorter rays).
TrainTestSplit splitScans(const std::vector<PointScan>& scans, const RealtimeRequest& request);

/// Runs the engines one after the other. The clock is simulated: the measured
/// time of an update decides which scans are lost, and nobody waits.
std::vector<RealtimeRun> runRealtime(const RealtimeRequest& request, std::ostream& log,
                                     ProgressMeter::Style style);

std::string realtimeAsText(const RealtimeRequest& request,
                           const std::vector<RealtimeRun>& runs);
std::string realtimeAsJson(const RealtimeRequest& request,
                           const std::vector<RealtimeRun>& runs);

}  // namespace superray
