// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file input_options.h
/// Options that several subcommands have.

#include <superray/core/sensor_model.h>
#include <superray/eval/point_scan.h>
#include <superray/eval/progress_meter.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace superray {

/// What `DATA` may be: for the footer of a --help.
extern const char* const kDataHelp;

/// --scans, --seed, --sensor, --poses: how data are read.
void addInputOptions(CLI::App& app, ScanSourceOptions& source, std::uint64_t& worldSeed);
/// A list of values, separated by commas (what follows them is something else).
template <class T>
CLI::Option* addListOption(CLI::App& app, const std::string& names, std::vector<T>& values,
                           const std::string& help, const std::string& type) {
    return app.add_option(names, values, help)
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name(type);
}
/// --engines, --threads.
void addEngineOptions(CLI::App& app, std::vector<std::string>& engines,
                      const std::string& defaultEngines, std::vector<unsigned>& threads);
/// --policy.
void addPolicyOption(CLI::App& app, UpdatePolicy& policy);
/// "name  description" of each engine.
std::string enginesHelp();
/// Progress as fits the error output.
ProgressMeter::Style progressStyle();
/// Progress of reading or writing scans, on the error output.
class LoadMeter {
 public:
    void update(std::uint64_t done, std::uint64_t total, std::uint64_t pointsPerScan);
    /// Leaves the line that was redrawn.
    void finish() { meter_.reset(); }

 private:
    std::unique_ptr<ProgressMeter> meter_;
    std::chrono::steady_clock::time_point start_;
};

/// Where figures go as JSON: --json prints them instead of text, as in all our programs;
/// --figures FILE writes them beside it.
struct FigureOptions {
    std::string json;  ///< empty without --json
    std::string file;  ///< empty without --figures

    bool asJson() const { return !json.empty(); }
};
void addFigureOptions(CLI::App& app, FigureOptions& figures);
/// \param data what is given as DATA: a file of JSON there is one that earlier versions wrote
/// \throws InputError if the options cannot be used
void checkFigureOptions(const FigureOptions& figures, const std::vector<std::string>& data);
/// The DATA of a command that takes one; a list, so that checkFigureOptions() sees what
/// follows --json. \throws InputError if there are several
const std::string& onlyData(const std::vector<std::string>& data, const std::string& command);
/// Prints text or JSON, and writes the file that is asked for.
void putFigures(const FigureOptions& figures, const std::string& text, const std::string& json);

/// Poses from a file if one is given.
void finishInputOptions(ScanSourceOptions& source);

}  // namespace superray
