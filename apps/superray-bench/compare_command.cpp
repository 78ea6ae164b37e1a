// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/bench_compare.h>
#include <superray/storage/atomic_file.h>

#include <iostream>
#include <memory>

#include "commands.h"
#include "input_options.h"

namespace superray {
namespace {

constexpr char kProtocol[] =
    R"(
Every engine gets the same points, in the map frame. In one process, the engines
take turns on each scan, in alternating order. What is timed is the update of
the map from points; putting the points into the container that an engine's
users have them in anyway is not. The ratio to octomap is the sum of its times
over all scans divided by the engine's: processor time for engines with one
thread, elapsed time for those with several.

Exact engines must come to the same map: if their digests differ, the exit code
is 1. octomap and mrpt-octomap count a cell once per scan, as --policy
oncePerScan does; octomap's digest may still differ from ours in cells that a
ray merely grazes.

Examples:
  superray-bench compare indoor --resolutions 0.1,0.2,0.4 --figures indoor.json
  superray-bench compare outdoor --resolutions 0.1 --scans 5 --engines octomap,grid
  superray-bench compare drive.rawlog --engines octomap,grid --threads 1,2
  superray-bench compare room.rawlog --engines grid,grid-perRay,grid-full
  superray-bench compare room.rawlog --engines grid --policies netEvidence,everyRay
)";

struct Arguments {
    CompareRequest request;
    std::vector<std::string> policies;
    FigureOptions figures;
};

int compare(Arguments& a) {
    finishInputOptions(a.request.source);
    if (!a.policies.empty()) a.request.policies.clear();
    for (const std::string& name : a.policies)
        a.request.policies.push_back(updatePolicyFromString(name));
    checkFigureOptions(a.figures, a.request.data);
    const auto runs = runCompare(a.request, std::cerr, progressStyle(), [&](const auto& soFar) {
        if (!a.figures.file.empty()) writeFileAtomically(a.figures.file, runsAsJson(soFar));
    });
    putFigures(a.figures, runsAsText(runs), runsAsJson(runs));
    const auto conflicts = digestConflicts(runs);
    for (const std::string& conflict : conflicts)
        std::cerr << "superray-bench: error: " << conflict << std::endl;
    return conflicts.empty() ? kSuccess : kDifferent;
}

}  // namespace

Command declareCompare(CLI::App& app) {
    auto arguments = std::make_shared<Arguments>();
    auto& a = *arguments;
    a.request.resolutions = {0.1};
    a.request.engines = {"octomap", "grid", "octree"};
    app.footer(kDataHelp + std::string("\n") + enginesHelp() + kProtocol);
    app.add_option("DATA", a.request.data, "Scans")->required()->type_name("DATA");
    addListOption(app, "--resolutions", a.request.resolutions, "Cell edges; default 0.1",
                  "METRES");
    addEngineOptions(app, a.request.engines, "octomap,grid,octree", a.request.threads);
    addListOption(app, "--policy,--policies", a.policies,
                  updatePolicyNames() + ", each run by itself; default netEvidence",
                  "POLICIES");
    app.add_option("-k,--threshold", a.request.superRayThreshold,
                   "Fewest points of an end cell that super rays group; default 20")
        ->type_name("K");
    addInputOptions(app, a.request.source, a.request.worldSeed);
    app.add_flag("--peak-memory", a.request.peakMemory,
                 "Measure the largest memory of each engine: one more pass, each in a process "
                 "of its own");
    app.add_flag("--unnecessary", a.request.unnecessary,
                 "Count traversals of cells that were saturated free before the scan (slow)");
    addFigureOptions(app, a.figures);
    return [arguments] { return compare(*arguments); };
}

}  // namespace superray
