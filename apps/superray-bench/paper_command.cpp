// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>
#include <superray/eval/paper_figures.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "commands.h"
#include "input_options.h"

namespace superray {
namespace {

constexpr char kHelp[] =
    R"(
Writes what the paper's Sec. V shows (Kwon et al., 2019), for this data:
  table2_update_time.csv   time per scan of every method and resolution
  table3_traversals.csv    rays, super rays, traversed cells, unnecessary ones
  table4_memory.csv        of the map, and largest of the process
  fig10_speedup.csv        over resolutions: over octomap, over walking each ray
  fig11_threshold.csv      time over the super-ray threshold k
  fig12_stages.csv         time by stage
  fig15_scans.csv          time of each scan
and, with gnuplot installed, a picture for each figure. The methods run on the
octree and on the block grid: perRay (every ray is walked), superRays, culling,
full (both), and the automatic choice; beside them liboctomap. A traversed cell
is unnecessary if it was saturated free before the scan.

Examples:
  superray-bench paper indoor -o paper_indoor
  superray-bench paper outdoor -o paper_outdoor --scans 10 --threads 1,2
  superray-bench paper drive.rawlog -o paper_drive --resolutions 0.2,0.4
)";

struct Arguments {
    PaperRequest request;
    std::string output;
    bool noPeakMemory = false;
};

/// Measuring takes long: a folder that cannot be made is found before.
void checkFolder(const std::string& folder) {
    namespace fs = std::filesystem;
    std::error_code error;
    fs::path place = fs::absolute(folder, error);
    while (!fs::exists(place, error) && place.has_relative_path()) place = place.parent_path();
    if (!fs::is_directory(place, error))
        throw InputError(folder + ": " + place.string() + " is a file, must be a folder");
    if (access(place.c_str(), W_OK) != 0)
        throw InputError(folder + ": " + place.string() + " cannot be written");
}

int paper(Arguments& a) {
    checkFolder(a.output);
    a.request.peakMemory = !a.noPeakMemory;
    finishInputOptions(a.request.source);
    const PaperRuns runs = runPaper(a.request, std::cerr, progressStyle());
    const bool drawn = writePaper(runs, a.output);
    std::cout << runsAsText(runs.compared) << "\nwritten to " << a.output << "\n";
    if (!drawn)
        std::cout << "no plots: gnuplot is not installed (Debian package gnuplot-nox); its "
                     "scripts are there\n";
    return kSuccess;
}

}  // namespace

Command declarePaper(CLI::App& app) {
    auto arguments = std::make_shared<Arguments>();
    auto& a = *arguments;
    app.footer(kDataHelp + std::string(kHelp));
    app.add_option("DATA", a.request.data, "Scans")->required()->type_name("DATA");
    app.add_option("-o,--output", a.output, "Folder to write to")
        ->required()
        ->type_name("FOLDER");
    addListOption(app, "--resolutions", a.request.resolutions,
                  "Cell edges; default 0.1,0.2,0.4,0.6,0.8,1", "METRES");
    app.add_option("-k,--threshold", a.request.superRayThreshold,
                   "Super-ray threshold of all but Fig. 11; default 20")
        ->type_name("K");
    addListOption(app, "--thresholds", a.request.thresholds,
                  "Those of Fig. 11; default 1,2,5,10,20,50,100,200,500", "K");
    addEngineOptions(app, a.request.engines, "octomap and all methods", a.request.threads);
    addPolicyOption(app, a.request.policy);
    app.add_flag("--no-peak-memory", a.noPeakMemory, "Leave out the pass that measures it");
    addInputOptions(app, a.request.source, a.request.worldSeed);
    return [arguments] { return paper(*arguments); };
}

}  // namespace superray
