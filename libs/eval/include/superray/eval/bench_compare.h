// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file bench_compare.h
/// Engines on the same scans, taking turns: time, work, memory and contents.

#include <superray/eval/bench_engine.h>
#include <superray/eval/progress_meter.h>

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace superray {

struct CompareRequest {
    std::vector<std::string> data;        ///< see PointScanRequest
    std::vector<double> resolutions;      ///< [m]
    std::vector<std::string> engines;     ///< names of benchEngines()
    std::vector<unsigned> threads = {1};  ///< of the engines that have threads
    /// Engines that can are run with each of them.
    std::vector<UpdatePolicy> policies = {UpdatePolicy::netEvidence};
    std::uint32_t superRayThreshold = 20;
    ScanSourceOptions source;  ///< how recorded data are read; maxScans for all data
    std::uint64_t worldSeed = 1;
    bool peakMemory = false;   ///< one more pass, each engine in a process of its own
    bool unnecessary = false;  ///< count unnecessary traversals (slow; one policy)
    /// \throws InputError naming what is wrong, before any work
    void validate() const;
};

/// One engine on one input at one resolution.
struct BenchRun {
    std::string data;
    double resolution = 0;  ///< [m]
    std::string engine;
    unsigned threads = 1;
    std::string policy;
    bool exact = false;  ///< see BenchEngineInfo
    std::uint64_t scans = 0, points = 0;
    /// Each scan [ms]: elapsed time, and processor time of all threads.
    std::vector<double> wallMs, cpuMs;
    /// octomap's time over all scans divided by this engine's; see comparedMs().
    std::optional<double> ratioToOctomap;
    std::size_t mapBytes = 0;
    /// Largest growth of a process that does nothing else.
    std::optional<std::uint64_t> peakBytes;
    std::string digest;
    BenchWork work;  ///< sum over all scans
    std::vector<BenchWork> workOfScan;
    /// Traversed cells that were saturated free before the scan, so that no
    /// miss could change them.
    std::optional<std::uint64_t> unnecessaryCells;
};

/// The times of a run that comparisons go by [ms]: processor time with one
/// thread, which other programs disturb less; elapsed time with several.
inline const std::vector<double>& comparedMs(const BenchRun& run) {
    return run.threads == 1 ? run.cpuMs : run.wallMs;
}

double meanOf(const std::vector<double>& values);    ///< 0 for none
double medianOf(const std::vector<double>& values);  ///< 0 for none

/// Runs everything. Engines take turns on each scan, in alternating order.
/// \param log what is being done, and progress in the given style
/// \param onRuns told all runs so far after each input and resolution, so that
///        they are not lost if something breaks later
/// \throws InputError
std::vector<BenchRun> runCompare(
    const CompareRequest& request, std::ostream& log, ProgressMeter::Style style,
    const std::function<void(const std::vector<BenchRun>&)>& onRuns = {});

/// One run for each engine (and number of threads) on scans that are loaded.
/// \param resolution [m]
std::vector<BenchRun> compareEngines(const PointScans& scans, double resolution,
                                     const CompareRequest& request, std::ostream& log,
                                     ProgressMeter::Style style);

/// Exact engines that do not agree: a line for each group of equal data,
/// resolution and policy with several digests. Empty if all is well.
std::vector<std::string> digestConflicts(const std::vector<BenchRun>& runs);

/// An object with `runs`; its fields are described in doc/benchmarks.md.
std::string runsAsJson(const std::vector<BenchRun>& runs);
/// A table per input and resolution.
std::string runsAsText(const std::vector<BenchRun>& runs);

}  // namespace superray
