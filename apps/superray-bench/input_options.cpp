// SPDX-License-Identifier: BSD-3-Clause
#include "input_options.h"

#include <superray/eval/bench_engine.h>
#include <superray/eval/input_error.h>
#include <superray/eval/output_paths.h>
#include <superray/maps/option_text.h>
#include <superray/storage/atomic_file.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

namespace superray {
namespace {

constexpr const char* kFlagGiven = "true";  // what CLI11 takes a flag without a value for

[[noreturn]] void refuseJsonFile(const std::string& file) {
    throw InputError("--json takes no file, got '" + file +
                     "': it prints to the standard output; --figures " + file +
                     " writes all figures");
}

}  // namespace

const char* const kDataHelp =
    R"(DATA is a simulated world, for which no file is needed, or recorded scans:
  indoor    corridor with rooms, 66 scans of 89,446 points
  outdoor   campus, 81 scans of 247,817 points, ranges to 80 m
  walker    hall with a walker and a box that is taken away, 60 scans of 131,072 points
  a file    .rawlog, .simplemap, .graph, .bag, .db3, .mcap, .pcd, .ply, .las, .pcap, or
            a folder (ROS 2, KITTI, RGB-D, clouds);
            'superray-map inspect' tells what is in it
)";

void addInputOptions(CLI::App& app, ScanSourceOptions& source, std::uint64_t& worldSeed) {
    app.add_option("--scans", source.maxScans, "Use the first so many scans; default: all")
        ->type_name("N");
    app.add_option("--seed", worldSeed, "Seed of simulated worlds; default 1")->type_name("N");
    app.add_option("--sensor", source.sensorLabel,
                   "Sensor labels of recorded data, comma-separated; default: all")
        ->type_name("LABELS");
    app.add_option("--poses", source.posesFile,
                   "Robot poses of recorded data: TUM or MRPT text")
        ->type_name("FILE");
}

void addEngineOptions(CLI::App& app, std::vector<std::string>& engines,
                      const std::string& defaultEngines, std::vector<unsigned>& threads) {
    addListOption(app, "--engines", engines, "Default: " + defaultEngines, "NAMES");
    addListOption(app, "--threads", threads,
                  "Numbers of threads, each run by itself; default 1", "N");
}

void addPolicyOption(CLI::App& app, UpdatePolicy& policy) {
    app.add_option_function<std::string>(
           "--policy",
           [&policy](const std::string& name) { policy = updatePolicyFromString(name); },
           updatePolicyNames() + "; default " + toString(policy))
        ->type_name("POLICY");
}

void addFigureOptions(CLI::App& app, FigureOptions& figures) {
    app.add_flag("--json", figures.json, "One JSON object instead of text");
    app.add_option("--figures", figures.file, "Write all figures (.json)")->type_name("OUTPUT");
}

void checkFigureOptions(const FigureOptions& figures, const std::vector<std::string>& data) {
    if (figures.asJson()) {
        if (figures.json != kFlagGiven) refuseJsonFile(figures.json);
        for (const std::string& name : data)
            if (equalIgnoringCase(std::filesystem::path(name).extension().string(), ".json"))
                refuseJsonFile(name);
    }
    if (!figures.file.empty()) checkOutputPath(figures.file, {".json"});
}

const std::string& onlyData(const std::vector<std::string>& data, const std::string& command) {
    if (data.size() != 1)
        throw InputError(command + " replays one DATA, got " + std::to_string(data.size()));
    return data.front();
}

void putFigures(const FigureOptions& figures, const std::string& text,
                const std::string& json) {
    std::cout << (figures.asJson() ? json : text);
    if (!figures.file.empty()) writeFileAtomically(figures.file, json);
}

void finishInputOptions(ScanSourceOptions& source) {
    if (!source.posesFile.empty()) source.poses = PoseOrigin::file;
}

std::string enginesHelp() {
    std::string text = "Engines:\n";
    for (const auto& engine : benchEngines()) {
        std::string name = "  " + engine.name;
        name.resize(std::max<std::size_t>(name.size() + 1, 20), ' ');
        text += name + engine.description + "\n";
    }
    return text;
}

ProgressMeter::Style progressStyle() {
    return isatty(STDERR_FILENO) != 0 ? ProgressMeter::Style::terminal
                                      : ProgressMeter::Style::log;
}

void LoadMeter::update(std::uint64_t done, std::uint64_t total, std::uint64_t pointsPerScan) {
    const auto now = std::chrono::steady_clock::now();
    if (!meter_) {
        meter_ = std::make_unique<ProgressMeter>(std::cerr, progressStyle());
        start_ = now;
    }
    BuildProgress progress;
    progress.scans = done;
    progress.totalScans = total;
    progress.rays = done * pointsPerScan;
    progress.seconds = std::chrono::duration<double>(now - start_).count();
    meter_->update(progress);
}

}  // namespace superray
