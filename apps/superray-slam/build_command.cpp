// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>
#include <superray/eval/map_output.h>
#include <superray/eval/map_request.h>
#include <superray/eval/progress_meter.h>
#include <superray/slam/live_view.h>
#include <superray/slam/range_slam.h>
#include <superray/slam/slam_output.h>
#include <unistd.h>

#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>

#include "commands.h"

namespace superray {
namespace {

constexpr char kExamples[] =
    R"(Robot poses in the recording are not used. Each scan is registered against the map
of the key frames before it; there is no loop closure. Outputs, by extension:
  .tum        trajectory of the robot: t x y z qx qy qz qw
  .srmap      the map
  .simplemap  key frames: poses and observations, for MRPT's programs
  .3Dscene    map and trajectory, for SceneViewer3D

The defaults suit a lidar on a car. share/config_files has files for other
sensors: superray-slam-rgbd.ini, superray-slam-lidar-indoor.ini.

Examples:
  superray-slam build drive.rawlog -o drive.tum drive.srmap drive.3Dscene
  superray-slam build room.rawlog -o room.tum --config superray-slam-rgbd.ini
  superray-slam build hall.rawlog -o hall.tum --yaw-search 36 --view
)";

struct Arguments {
    std::string input;
    std::vector<std::string> outputs;
    std::string config, mapSection;
    MapRequest map;
    ScanSourceOptions source;
    std::optional<std::string> resolutions;
    std::optional<double> pointSpacing, maxRange, minRange, yawSearch;
    std::optional<double> keyFrameDistance, keyFrameAngle;
    bool useOdometry = false, acceptTruncated = false, view = false;
    std::string start;
};

TSlamOptions slamOptions(const Arguments& a) {
    TSlamOptions options;
    if (!a.config.empty()) options.loadFromFile(a.config);
    auto& r = options.registration;
    r.resolutions = a.resolutions.value_or(r.resolutions);
    r.pointSpacing = a.pointSpacing.value_or(r.pointSpacing);
    r.maxRange = a.maxRange.value_or(r.maxRange);
    r.minRange = a.minRange.value_or(r.minRange);
    r.yawSearch = a.yawSearch.value_or(r.yawSearch);
    auto& k = options.keyFrames;
    k.insertionLinDistance = a.keyFrameDistance.value_or(k.insertionLinDistance);
    k.insertionAngDistance = a.keyFrameAngle.value_or(k.insertionAngDistance);
    if (a.useOdometry) k.prior = MotionPrior::odometry;
    options.validate();
    return options;
}

mrpt::maps::CMetricMap::Ptr makeSlamMap(const Arguments& a) {
    MapRequest request = a.map;
    request.sensorLabels = a.source.sensorLabel;
    if (!a.mapSection.empty()) {
        if (a.config.empty()) throw InputError("--map-section needs --config");
        request.configFile = a.config;
        request.section = a.mapSection;
    }
    return makeMap(request);
}

mrpt::poses::CPose3D startPose(const std::string& text) {
    mrpt::poses::CPose3D pose;
    if (text.empty()) return pose;
    std::istringstream in(text);
    double v[6];
    for (double& value : v) in >> value;
    std::string rest;
    if (!in || in >> rest)
        throw InputError("--start '" + text +
                         "': must be six numbers, 'x y z yaw pitch roll' [m, degrees]");
    constexpr double kDegrees = M_PI / 180;
    pose.setFromValues(v[0], v[1], v[2], v[3] * kDegrees, v[4] * kDegrees, v[5] * kDegrees);
    return pose;
}

void print(const SlamReport& r) {
    const auto scans = static_cast<double>(r.scans);
    std::cout << std::fixed << "scans      " << formatCount(r.scans) << " in "
              << formatSeconds(r.totalSeconds) << ", " << std::setprecision(1)
              << scans / r.totalSeconds << " scans/s\n"
              << "time       per scan: reading " << 1e3 * r.readSeconds / scans
              << " ms, registration " << 1e3 * r.registrationSeconds / scans
              << " ms, insertion " << 1e3 * r.insertionSeconds / scans << " ms\n"
              << "key frames " << formatCount(r.keyFrames) << "\n"
              << "goodness   " << std::setprecision(2) << r.goodnessSum / scans
              << " of the points on a surface\n";
    if (r.weak > 0)
        std::cout << "weak       " << formatCount(r.weak)
                  << " scans agree too little with the map to be inserted: doubt their poses\n";
    if (r.unusable > 0)
        std::cout << "left out   " << formatCount(r.unusable)
                  << " scans without usable ranges or points\n";
    if (r.skipped.otherLabel > 0)
        std::cout << "left out   " << formatCount(r.skipped.otherLabel)
                  << " scans of another sensor\n";
    if (r.skipped.withoutPose > 0)
        std::cout << "left out   " << formatCount(r.skipped.withoutPose)
                  << " scans outside the time of the odometry\n";
    if (!r.warning.empty()) std::cout << "warning    " << r.warning << "\n";
}

int build(const Arguments& arguments) {
    for (const auto& output : arguments.outputs) checkSlamOutputPath(output);
    const TSlamOptions options = slamOptions(arguments);
    ScanSourceOptions sourceOptions = arguments.source;
    sourceOptions.poses = options.keyFrames.prior == MotionPrior::odometry ? PoseOrigin::motion
                                                                           : PoseOrigin::fixed;
    if (arguments.acceptTruncated) sourceOptions.truncation = Truncation::accept;
    RangeSlam slam(options, makeSlamMap(arguments), startPose(arguments.start));
    const auto source = openScanSource(arguments.input, sourceOptions);
    checkSensorLabels(sourceOptions.sensorLabel, source->sensorLabels());
    std::unique_ptr<LiveView> view;
    if (arguments.view) view = std::make_unique<LiveView>();

    SlamReport report;
    {
        const bool terminal = isatty(STDERR_FILENO) != 0;
        ProgressMeter meter(
            std::cerr, terminal ? ProgressMeter::Style::terminal : ProgressMeter::Style::log);
        BuildProgress progress;
        progress.totalScans = source->total();
        report = runSlam(*source, slam, options, [&](const SlamReport& now, const SlamStep&) {
            progress.scans = now.scans;
            progress.seconds = now.totalSeconds;
            meter.update(progress);
            if (view) view->show(slam);
        });
    }
    print(report);
    for (const auto& output : arguments.outputs) {
        writeSlamOutput(slam, output);
        std::cout << "output     " << describeOutput(output) << "\n";
    }
    return kSuccess;
}

}  // namespace

Command declareBuild(CLI::App& app) {
    auto arguments = std::make_shared<Arguments>();
    auto& a = *arguments;
    app.footer(kExamples);
    app.add_option("INPUT", a.input, "Recorded scans (.rawlog, KITTI folder, ...)")
        ->required()
        ->type_name("FILE");
    app.add_option("-o,--output", a.outputs,
                   "Files to write: .tum, .srmap, .simplemap, .3Dscene")
        ->required()
        ->type_name("OUTPUT");
    app.add_option("--config", a.config,
                   "Options from an .ini file: [registration], [keyframes], [icp]")
        ->type_name("FILE");
    app.add_option("--map-section", a.mapSection,
                   "Options of the map from its sections [S_creationOpts], [S_insertOpts], ...")
        ->type_name("S");
    app.add_option("--map", a.map.className, "Class of the map; default CSuperRayGridMap3D")
        ->type_name("CLASS");
    app.add_option("--resolution", a.map.resolution, "Cell edge of the map; default 0.1")
        ->type_name("METRES");
    app.add_option("--threads", a.map.threads, "Threads to insert with; default 1")
        ->type_name("N");
    app.add_option("--sensor", a.source.sensorLabel, "Sensor labels to use; default: all")
        ->type_name("LABELS");
    app.add_option("--scans", a.source.maxScans, "Stop after so many scans")->type_name("N");
    app.add_option("--start", a.start, "First pose: 'x y z yaw pitch roll' [m, degrees]")
        ->type_name("POSE");
    app.add_flag("--odometry", a.useOdometry,
                 "Start each registration from the recording's odometry or actions, not from "
                 "constant velocity");
    app.add_flag("--accept-truncated", a.acceptTruncated,
                 "Use the whole scans of a broken input instead of refusing it");
    app.add_flag("--view", a.view, "Show map and trajectory in a window");
    const std::string group = "Registration (override the configuration file)";
    app.add_option("--levels", a.resolutions, "Cells of the reference maps, e.g. '1.0, 0.5'")
        ->type_name("METRES,...")
        ->group(group);
    app.add_option("--point-spacing", a.pointSpacing, "One point per cube of this edge")
        ->type_name("METRES")
        ->group(group);
    app.add_option("--min-range", a.minRange, "Nearer returns do not take part")
        ->type_name("METRES")
        ->group(group);
    app.add_option("--max-range", a.maxRange, "Nor do farther ones")
        ->type_name("METRES")
        ->group(group);
    app.add_option("--yaw-search", a.yawSearch,
                   "Turns to try to either side before registration")
        ->type_name("DEGREES")
        ->group(group);
    app.add_option("--key-frame-distance", a.keyFrameDistance,
                   "Insert a scan after moving so far")
        ->type_name("METRES")
        ->group(group);
    app.add_option("--key-frame-angle", a.keyFrameAngle, "Or after turning so much")
        ->type_name("DEGREES")
        ->group(group);
    return [arguments] { return build(*arguments); };
}

}  // namespace superray
