// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file paper_figures.h
/// The tables and figures of the paper's experiments (Sec. V), for any data.

#include <superray/eval/bench_compare.h>

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace superray {

struct PaperRequest {
    std::string data;                                                  ///< see PointScanRequest
    std::vector<double> resolutions = {0.1, 0.2, 0.4, 0.6, 0.8, 1.0};  ///< [m]
    std::vector<unsigned> threads = {1};
    std::uint32_t superRayThreshold = 20;
    /// Values of k for Fig. 11.
    std::vector<std::uint32_t> thresholds = {1, 2, 5, 10, 20, 50, 100, 200, 500};
    /// octomap, and all methods on both maps.
    std::vector<std::string> engines = {
        "octomap", "octree-perRay", "octree-superRays", "octree-culling", "octree-full",
        "octree",  "grid-perRay",   "grid-superRays",   "grid-culling",   "grid-full",
        "grid"};
    UpdatePolicy policy = UpdatePolicy::everyRay;
    ScanSourceOptions source;
    std::uint64_t worldSeed = 1;
    bool peakMemory = true;
};

/// A file to write.
struct NamedText {
    std::string name, text;
};

/// All runs of a request.
struct PaperRuns {
    std::vector<BenchRun> compared;  ///< every engine and resolution
    struct AtThreshold {
        std::uint32_t k;
        std::vector<BenchRun> runs;  ///< engines with super rays, every resolution
    };
    std::vector<AtThreshold> overThreshold;
};

/// Takes its time. \throws InputError
PaperRuns runPaper(const PaperRequest& request, std::ostream& log, ProgressMeter::Style style);

/// table2_update_time.csv, table3_traversals.csv, table4_memory.csv,
/// fig10_speedup.csv, fig11_threshold.csv, fig12_stages.csv, fig15_scans.csv;
/// doc/benchmarks.md tells what they hold.
std::vector<NamedText> paperTables(const PaperRuns& runs);
/// gnuplot scripts with their data in them: fig*.gp, each draws fig*.png in the
/// working folder.
std::vector<NamedText> paperPlots(const PaperRuns& runs);

/// Writes all of it to a folder, which is made if need be, and draws the plots
/// if gnuplot is installed.
/// \return false if there is no gnuplot; the scripts are written all the same
/// \throws InputError if something cannot be written or gnuplot fails
bool writePaper(const PaperRuns& runs, const std::string& folder);

}  // namespace superray
