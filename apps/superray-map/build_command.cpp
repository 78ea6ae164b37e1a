// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>
#include <superray/eval/map_build.h>
#include <superray/eval/map_output.h>
#include <superray/eval/map_request.h>
#include <superray/eval/output_paths.h>
#include <superray/eval/progress_meter.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "commands.h"
#include "pose_options.h"

namespace superray {
namespace {

constexpr char kExamples[] =
    R"(Inputs: .rawlog (observations, or action/observation pairs), .simplemap,
OctoMap's .graph, bags of ROS 1 (.bag) and 2 (.db3, .mcap, folders), .pcd, .ply and
.las (one or a folder), .pcap (Velodyne), folders of KITTI (odometry, raw), MulRan,
TUM RGB-D and ICL-NUIM. Several inputs make one map. Poses come from the input unless
--poses or --fixed-robot is given.

Examples:
  superray-map build room.rawlog -o room.srmap --resolution 0.05
  superray-map build sequences/07 -o kitti.srmap --resolution 0.2 --threads 2
  superray-map build log.rawlog -o log.srmap --poses log.tum --sensor HDL64
  superray-map build drive.bag -o drive.srmap --sensor /points --pose-label "tf map"
  superray-map build one_scan.rawlog -o scan.srmap --fixed-robot
  superray-map build drive.rawlog -o drive.srmap --poses drive.tum --deskew
  superray-map build log.rawlog -o plan.srmap --map CSuperRayGridMap2D
  superray-map build log.rawlog -o log.srmap --config maps.ini --section room
)";

struct Arguments {
    std::vector<std::string> inputs;
    std::string output;
    MapRequest map;
    ScanSourceOptions source;
    PoseArguments poses;
    bool acceptTruncated = false, deskew = false, json = false;
};

ScanSources markAll(const Arguments& arguments, const std::string& sensorLabels) {
    ScanSourceOptions options = arguments.source;
    options.sensorLabel = sensorLabels;
    options.poses = poseOrigin(arguments.poses, options);
    if (arguments.acceptTruncated) options.truncation = Truncation::accept;
    ScanSources sources;
    std::vector<std::string> labels;
    for (const auto& input : arguments.inputs) {
        sources.push_back(openScanSource(input, options));
        const auto more = sources.back()->sensorLabels();
        labels.insert(labels.end(), more.begin(), more.end());
    }
    checkSensorLabels(sensorLabels, labels);
    return sources;
}

/// A recording that is given twice would be inserted twice.
void refuseTwins(const std::vector<std::string>& inputs) {
    std::error_code error;
    for (std::size_t i = 0; i < inputs.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
            if (std::filesystem::equivalent(inputs[i], inputs[k], error))
                throw InputError(inputs[i] + ": is given twice (" + inputs[k] + ")");
}

int build(const Arguments& arguments) {
    checkOutputPath(arguments.output, {".srmap"});
    refuseTwins(arguments.inputs);
    const auto map = makeMap(arguments.map);
    const auto& info = dynamic_cast<const SuperRayMapInterface&>(*map);
    const auto sources = markAll(arguments, info.options().insertion.sensorLabel);

    BuildReport report;
    {
        const bool terminal = isatty(STDERR_FILENO) != 0;
        ProgressMeter meter(
            std::cerr, terminal ? ProgressMeter::Style::terminal : ProgressMeter::Style::log);
        report = buildMap(
            sources, *map, arguments.source.maxScans,
            [&](const BuildProgress& progress) { meter.update(progress); },
            arguments.deskew ? ScanMotion::alongTrajectory : ScanMotion::none);
    }
    info.saveToFile(arguments.output);

    if (arguments.json) {
        std::cout << describeAsJson(report, info, arguments.output);
        return kSuccess;
    }
    const auto cells = info.cellTotals();
    std::cout << describe(report) << "rule       " << describeRule(info.options().insertion)
              << "\n"
              << "cells      " << formatCount(cells.known)
              << " known: " << formatCount(cells.occupied) << " occupied, "
              << formatCount(cells.free) << " free\n"
              << "output     " << describeOutput(arguments.output) << "\n";
    return kSuccess;
}

}  // namespace

Command declareBuild(CLI::App& app) {
    auto arguments = std::make_shared<Arguments>();
    auto& a = *arguments;
    app.footer(kExamples);
    app.add_option("INPUT", a.inputs, "Recorded scans")->required()->type_name("FILE");
    app.add_option("-o,--output", a.output, "Map to write (.srmap)")
        ->required()
        ->type_name("OUTPUT");
    app.add_option("--map", a.map.className,
                   "CSuperRayGridMap3D (default), CSuperRayOctoMap, CSuperRayGridMap2D or "
                   "CSuperRayQuadMap")
        ->type_name("CLASS");
    app.add_option("--resolution", a.map.resolution, "Cell edge; default 0.1")
        ->type_name("METRES");
    app.add_option("--max-range", a.map.maxRange,
                   "Longer rays are cut here and only clear space; default: no limit")
        ->type_name("METRES");
    app.add_option("--min-range", a.map.minRange, "Nearer points are left out; default 0")
        ->type_name("METRES");
    app.add_option("--window", a.map.windowRadius,
                   "Forget what is farther from the sensor after each scan; default: nothing")
        ->type_name("METRES");
    app.add_option("--max-memory", a.map.maxMemoryMegabytes,
                   "Stop, without output, before the map would take more; default: no bound")
        ->type_name("MB");
    app.add_option("--sensor", a.map.sensorLabels,
                   "Sensor labels to use, comma-separated; default: all")
        ->type_name("LABELS");
    app.add_option("--scans", a.source.maxScans, "Stop after so many scans")->type_name("N");
    addPoseOptions(app, a.poses, a.source);
    addDepthCameraOptions(app, a.source);
    app.add_flag(
           "--deskew", a.deskew,
           "The robot moved during each scan: every ray starts where the sensor was at its "
           "time (raw Velodyne packets; 2D scans with sweepDuration in --config). Needs "
           "poses by time")
        ->excludes("--fixed-robot");
    app.add_flag("--accept-truncated", a.acceptTruncated,
                 "Map the whole scans of a broken input instead of refusing it");
    app.add_option("--config", a.map.configFile, "Options from an .ini file")
        ->type_name("FILE");
    app.add_option("--section", a.map.section,
                   "Its section: a multi-metric-map, or S of [S_creationOpts], [S_insertOpts], "
                   "[S_likelihoodOpts], [S_renderOpts]")
        ->type_name("S");
    app.add_option(
           "--policy", a.map.policy,
           "How the rays of a scan act on a cell: netEvidence (default; keeps surfaces "
           "that few rays end in), everyRay (as the super ray paper) or oncePerScan (as "
           "OctoMap's insertPointCloud); each with its own probabilities")
        ->type_name("POLICY");
    app.add_option(
           "--method", a.map.method,
           "auto (default), full, culling, superRays, perRay or reference: the same map "
           "in other times")
        ->type_name("METHOD");
    app.add_option("--threads", a.map.threads, "Threads; default 1")->type_name("N");
    app.add_flag("--json", a.json, "One JSON object instead of text");
    return [arguments] { return build(*arguments); };
}

}  // namespace superray
