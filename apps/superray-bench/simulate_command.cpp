// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/map_output.h>
#include <superray/eval/output_paths.h>
#include <superray/eval/scan_character.h>
#include <superray/eval/simulated_rawlog.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "commands.h"
#include "input_options.h"

namespace superray {
namespace {

constexpr char kHelp[] =
    R"(WORLD is indoor (a corridor with furnished rooms, 66 scans of 89,446 points),
outdoor (a campus with buildings, trees, poles and cars, 81 scans of 247,817
points, ranges to 80 m), or walker (a hall with somebody walking by and a box that
is taken away, the sensor stands still, 60 scans of 131,072 points). Worlds and the noise of their scans depend on the seed
alone. The recording holds robot poses (label POSE) and point clouds (label
SIMULATED); beside it, a .tum file has the true poses as text.

Examples:
  superray-bench simulate indoor -o indoor.rawlog
  superray-bench simulate outdoor -o campus.rawlog --scans 20 --seed 7
  superray-map build indoor.rawlog -o indoor.srmap --resolution 0.1
)";

struct Arguments {
    std::string world, output;
    std::uint64_t scans = std::numeric_limits<std::uint64_t>::max();
    std::uint64_t seed = SimulatedWorld::kDefaultSeed;
    double resolution = 0.1;  // m
};

int simulate(const Arguments& a) {
    checkOutputPath(a.output, {".rawlog"});
    const std::string poses = std::filesystem::path(a.output).replace_extension(".tum");
    checkOutputPath(poses, {".tum"});
    checkOutputsApart({}, {a.output, poses});
    const SimulatedWorld world(a.world, a.seed);
    PointScanRequest request;
    request.data = a.world;
    request.worldSeed = a.seed;
    request.source.maxScans = a.scans;
    const PointScans scans = loadPointScans(request);
    LoadMeter meter;
    writeSimulatedRawlog(world, a.scans, a.output,
                         [&](std::uint64_t done, std::uint64_t total) {
                             meter.update(done, total, world.pointsPerScan());
                         });
    meter.finish();
    std::cout << describe(characterOf(scans.scans, a.resolution)) << "output          "
              << describeOutput(a.output) << "\n";
    return kSuccess;
}

}  // namespace

Command declareSimulate(CLI::App& app) {
    auto arguments = std::make_shared<Arguments>();
    auto& a = *arguments;
    app.footer(kHelp);
    app.add_option("WORLD", a.world, "indoor, outdoor or walker")
        ->required()
        ->type_name("WORLD");
    app.add_option("-o,--output", a.output, "Recording to write (.rawlog)")
        ->required()
        ->type_name("OUTPUT");
    app.add_option("--scans", a.scans, "Write the first so many scans; default: all")
        ->type_name("N");
    app.add_option("--seed", a.seed, "Default 1")->type_name("N");
    app.add_option("--resolution", a.resolution,
                   "Cell edge for the account of the scans; default 0.1")
        ->type_name("METRES");
    return [arguments] { return simulate(*arguments); };
}

}  // namespace superray
