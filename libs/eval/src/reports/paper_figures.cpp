// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>
#include <superray/eval/paper_figures.h>
#include <superray/storage/atomic_file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <ostream>

namespace superray {
namespace {

namespace fs = std::filesystem;

/// Engines of which the time depends on k.
bool groups(const std::string& engine) {
    return engine == "grid-superRays" || engine == "grid-full" ||
           engine == "octree-superRays" || engine == "octree-full";
}

enum class Drawn { yes, noProgram };

/// Runs gnuplot on a script in a folder. \throws InputError if it fails
Drawn draw(const fs::path& folder, const std::string& script) {
    constexpr int kNoProgram = 127;
    const pid_t child = fork();
    if (child < 0) throw InputError("cannot start gnuplot");
    if (child == 0) {
        if (chdir(folder.c_str()) == 0)
            execlp("gnuplot", "gnuplot", script.c_str(), static_cast<char*>(nullptr));
        _exit(kNoProgram);
    }
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFEXITED(status) && WEXITSTATUS(status) == kNoProgram) return Drawn::noProgram;
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        throw InputError("gnuplot failed on " + (folder / script).string());
    return Drawn::yes;
}

void write(const fs::path& folder, const NamedText& file) {
    writeFileAtomically((folder / file.name).string(), file.text);
}

}  // namespace

PaperRuns runPaper(const PaperRequest& request, std::ostream& log, ProgressMeter::Style style) {
    CompareRequest compare;
    compare.data = {request.data};
    compare.resolutions = request.resolutions;
    compare.engines = request.engines;
    compare.threads = request.threads;
    compare.policies = {request.policy};
    compare.superRayThreshold = request.superRayThreshold;
    compare.source = request.source;
    compare.worldSeed = request.worldSeed;
    compare.peakMemory = request.peakMemory;
    compare.unnecessary = true;
    compare.validate();

    const PointScans scans = loadPointScans({request.data, request.source, request.worldSeed});
    const auto runAll = [&](const CompareRequest& r) {
        std::vector<BenchRun> runs;
        for (const double resolution : r.resolutions) {
            auto more = compareEngines(scans, resolution, r, log, style);
            std::move(more.begin(), more.end(), std::back_inserter(runs));
        }
        return runs;
    };
    PaperRuns result;
    result.compared = runAll(compare);

    compare.peakMemory = compare.unnecessary = false;
    compare.threads = {request.threads.front()};
    compare.engines.erase(std::remove_if(compare.engines.begin(), compare.engines.end(),
                                         [](const auto& name) { return !groups(name); }),
                          compare.engines.end());
    if (compare.engines.empty()) return result;
    for (const std::uint32_t k : request.thresholds) {
        log << "k = " << k << std::endl;
        compare.superRayThreshold = k;
        compare.validate();
        result.overThreshold.push_back({k, runAll(compare)});
    }
    return result;
}

bool writePaper(const PaperRuns& runs, const std::string& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (!fs::is_directory(folder, error)) throw InputError(folder + ": cannot be made");
    for (const NamedText& table : paperTables(runs)) write(folder, table);
    bool drawn = true;
    for (const NamedText& plot : paperPlots(runs)) {
        write(folder, plot);
        drawn = drawn && draw(folder, plot.name) == Drawn::yes;
    }
    return drawn;
}

}  // namespace superray
