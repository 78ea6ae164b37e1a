// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/soak.h>

#include <algorithm>
#include <iostream>
#include <memory>

#include "commands.h"
#include "input_options.h"

namespace superray {
namespace {

constexpr char kProtocol[] =
    R"(
The scans are inserted again and again, each lap where the last one ended, so that the
drive goes on; near the limit of what can be addressed it turns and comes back. What is
farther from the sensor than --window is forgotten. The memory of the map and of the
process (resident set) is printed at even intervals. It is flat if, once the window has
filled (a fifth of the scans), it is not more than 5 % higher in the later half than in
the earlier one; the exit code is 1 if it grows.

Examples:
  superray-bench soak outdoor --window 30
  superray-bench soak drive.rawlog --insertions 100000 --classes CSuperRayOctoMap
)";

struct Arguments {
    SoakRequest request;
    std::vector<std::string> data;
    FigureOptions figures;
};

int soak(Arguments& a) {
    finishInputOptions(a.request.source);
    checkFigureOptions(a.figures, a.data);
    a.request.data = onlyData(a.data, "soak");
    const auto runs = runSoak(a.request, std::cerr, progressStyle());
    putFigures(a.figures, soakAsText(a.request, runs), soakAsJson(a.request, runs));
    const bool flat =
        std::all_of(runs.begin(), runs.end(), [](const SoakRun& run) { return isFlat(run); });
    return flat ? kSuccess : kDifferent;
}

}  // namespace

Command declareSoak(CLI::App& app) {
    auto arguments = std::make_shared<Arguments>();
    auto& a = *arguments;
    app.footer(kDataHelp + std::string(kProtocol));
    app.add_option("DATA", a.data, "Scans")->required()->type_name("DATA");
    app.add_option("--insertions", a.request.insertions, "Scans to insert; default 10000")
        ->type_name("N");
    addListOption(app, "--classes", a.request.classes,
                  "Classes of maps; default CSuperRayGridMap3D", "LIST");
    app.add_option("--resolution", a.request.resolution, "Cell edge; default 0.2")
        ->type_name("METRES");
    app.add_option("--window", a.request.windowRadius,
                   "Option windowRadius of the maps; default 20, 0: none")
        ->type_name("METRES");
    app.add_option("--max-memory", a.request.maxMemoryMegabytes,
                   "Option max_memory_megabytes of the maps; default 0: none")
        ->type_name("MB");
    app.add_option("--points", a.request.pointsPerScan,
                   "Evenly chosen points of each scan; default 20000, 0: all")
        ->type_name("N");
    app.add_option("--threads", a.request.threads, "Default 1")->type_name("N");
    addInputOptions(app, a.request.source, a.request.worldSeed);
    addFigureOptions(app, a.figures);
    return [arguments] { return soak(*arguments); };
}

}  // namespace superray
