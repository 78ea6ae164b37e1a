// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/realtime.h>

#include <iostream>
#include <memory>

#include "commands.h"
#include "input_options.h"

namespace superray {
namespace {

constexpr char kProtocol[] =
    R"(
Scan i arrives at i / rate seconds. One that arrives while the map is still
being updated is lost. The clock is simulated: the elapsed time that each update
takes decides what is lost, and nothing waits. Times are those of this machine,
as busy as it is.

20 % of the points of every scan (seeded) are for testing: their end points
should be occupied (p > 0.7), and one point drawn along each of their rays, at
least two cells before its end, free (p < 0.3). Scans that were lost are tested
too. Maps are made of the other points, as in the paper, or of all points with
--keep-all-points, which gives the times of a robot that uses whole scans.

Our maps take memory from the system before the first scan (--reserve; the
option reserve_megabytes of the maps), as those of a robot that must keep up
would: page faults of a first scan can cost as much time as its update. MRPT's
COccupancyGridMap3D, of fixed size, does so too; OctoMap cannot.

What engines make of their probabilities is found by inserting rays, and printed.

Examples:
  superray-bench realtime drive.rawlog --rate 10 --resolution 0.2
  superray-bench realtime room.rawlog --rate 30 --resolution 0.05 --engines grid \
      --threads 2 --keep-all-points
)";

struct Arguments {
    RealtimeRequest request;
    std::vector<std::string> data;
    FigureOptions figures;
    bool keepAllPoints = false;
    bool ownModel = false;
};

int realtime(Arguments& a) {
    if (a.keepAllPoints) a.request.training = TrainingPoints::all;
    if (a.ownModel) a.request.peerModel = PeerModel::own;
    finishInputOptions(a.request.source);
    checkFigureOptions(a.figures, a.data);
    a.request.data = onlyData(a.data, "realtime");
    const auto runs = runRealtime(a.request, std::cerr, progressStyle());
    putFigures(a.figures, realtimeAsText(a.request, runs), realtimeAsJson(a.request, runs));
    return kSuccess;
}

}  // namespace

Command declareRealtime(CLI::App& app) {
    auto arguments = std::make_shared<Arguments>();
    auto& a = *arguments;
    a.request.engines = {"octomap", "grid", "octree"};
    app.footer(kDataHelp + std::string("\n") + enginesHelp() + kProtocol);
    app.add_option("DATA", a.data, "Scans")->required()->type_name("DATA");
    app.add_option("--rate", a.request.rate, "Scans a second; default 10")->type_name("HZ");
    app.add_option("--resolution", a.request.resolution, "Cell edge; default 0.2")
        ->type_name("METRES");
    addEngineOptions(app, a.request.engines, "octomap,grid,octree", a.request.threads);
    addPolicyOption(app, a.request.policy);
    app.add_flag("--keep-all-points", a.keepAllPoints, "Make maps of the test points too");
    app.add_flag("--own-model", a.ownModel,
                 "Other engines with their own defaults, instead of 0.7 / 0.4");
    app.add_option("--reserve", a.request.reserveMegabytes,
                   "Memory that grid and octree take before the first scan; default 256")
        ->type_name("MB");
    app.add_option("--test-seed", a.request.testSeed, "Choice of test points; default 1")
        ->type_name("N");
    addInputOptions(app, a.request.source, a.request.worldSeed);
    addFigureOptions(app, a.figures);
    return [arguments] { return realtime(*arguments); };
}

}  // namespace superray
