// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/stopwatch.h>
#include <superray/eval/bench_compare.h>
#include <superray/eval/input_error.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <numeric>
#include <ostream>
#include <set>
#include <sstream>
#include <tuple>

#include "engines/cpu_stopwatch.h"
#include "engines/peak_memory.h"
#include "engines/visit_count.h"

namespace superray {
namespace {

/// An engine at work, and what is known about it.
struct Contestant {
    const BenchEngineInfo* info;
    BenchEngineOptions options;
    std::unique_ptr<BenchEngine> engine;
    BenchRun run;
};

Contestant makeContestant(const PointScans& scans, double resolution,
                          const CompareRequest& request, const BenchEngineInfo& info,
                          UpdatePolicy policy, unsigned threads) {
    Contestant c;
    c.info = &info;
    c.options.resolution = resolution;
    c.options.threads = threads;
    c.options.policy = policy;
    c.options.superRayThreshold = request.superRayThreshold;
    c.options.bounds = scans.bounds;
    c.run.data = scans.name;
    c.run.resolution = resolution;
    c.run.engine = info.name;
    c.run.threads = threads;
    c.run.policy = info.ownPolicy.empty() ? toString(policy) : info.ownPolicy;
    c.run.exact = info.exact;
    c.run.scans = scans.scans.size();
    c.run.points = scans.points;
    if (info.exact && request.unnecessary) c.run.unnecessaryCells = 0;
    return c;
}

std::vector<Contestant> makeContestants(const PointScans& scans, double resolution,
                                        const CompareRequest& request) {
    const std::vector<unsigned> oneThread = {1};
    const std::vector<UpdatePolicy> itsOwn = {request.policies.front()};
    std::vector<Contestant> all;
    for (const std::string& name : request.engines) {
        const BenchEngineInfo& info = benchEngine(name);
        for (const UpdatePolicy policy : info.ownPolicy.empty() ? request.policies : itsOwn)
            for (const unsigned threads : info.threaded ? request.threads : oneThread)
                all.push_back(
                    makeContestant(scans, resolution, request, info, policy, threads));
    }
    return all;
}

void measurePeak(Contestant& c, const PointScans& scans) {
    c.run.peakBytes = peakGrowth([&] {
        const auto engine = c.info->make(c.options);
        for (const PointScan& scan : scans.scans) {
            engine->prepare(scan);
            engine->insert();
        }
    });
}

/// An engine that frees millions of small blocks leaves work to the allocator,
/// which does it bit by bit at the next large requests. Asks for such until they
/// are served at once, so that the next engine need not pay. (They are below the
/// size that is mapped rather than allocated.)
void settleAllocator() {
    constexpr double kAtOnce = 2e-6;  // [s]
    for (int i = 0; i < 5000; ++i) {
        const Stopwatch watch;
        volatile char* const block = static_cast<char*>(std::malloc(100000));
        if (block != nullptr) block[0] = 0;
        std::free(const_cast<char*>(block));
        if (watch.seconds() < kAtOnce) return;
    }
}

void insertTimed(Contestant& c, const PointScan& scan) {
    settleAllocator();
    c.engine->prepare(scan);
    const CpuStopwatch cpu;
    const Stopwatch wall;
    c.engine->insert();
    c.run.wallMs.push_back(1e3 * wall.seconds());
    c.run.cpuMs.push_back(1e3 * cpu.seconds());
    c.run.workOfScan.push_back(c.engine->work());
    c.run.work += c.run.workOfScan.back();
}

double totalMs(const BenchRun& run, bool cpu) {
    const auto& times = cpu ? run.cpuMs : run.wallMs;
    return std::accumulate(times.begin(), times.end(), 0.0);
}

void computeRatios(std::vector<Contestant>& all) {
    const auto octomap = std::find_if(all.begin(), all.end(),
                                      [](const auto& c) { return c.run.engine == "octomap"; });
    if (octomap == all.end()) return;
    for (Contestant& c : all) {
        const bool cpu = c.run.threads == 1;
        c.run.ratioToOctomap = totalMs(octomap->run, cpu) / totalMs(c.run, cpu);
    }
}

/// Cells of the scan that each way to walk it has to visit, all maps being equal.
void countUnnecessary(std::vector<Contestant>& all, const std::optional<VisitCount>& needed) {
    for (Contestant& c : all) {
        if (!c.run.unnecessaryCells) continue;
        const BenchWork& work = c.run.workOfScan.back();
        const bool grouped = work.superRays < work.rays;
        const std::uint64_t necessary =
            grouped ? needed->changeableOfSuperRays : needed->changeable;
        *c.run.unnecessaryCells +=
            work.traversedCells > necessary ? work.traversedCells - necessary : 0;
    }
}

}  // namespace

void CompareRequest::validate() const {
    if (data.empty()) throw InputError("no data given");
    if (engines.empty()) throw InputError("no engines given");
    for (const std::string& name : engines) benchEngine(name);
    if (std::set<std::string>(engines.begin(), engines.end()).size() != engines.size())
        throw InputError("an engine is given twice");
    if (resolutions.empty()) throw InputError("no resolutions given");
    for (const double resolution : resolutions) CellGeometry<3>{resolution};
    if (policies.empty()) throw InputError("no policy given");
    if (std::set<UpdatePolicy>(policies.begin(), policies.end()).size() != policies.size())
        throw InputError("a policy is given twice");
    if (unnecessary && policies.size() > 1)
        throw InputError("unnecessary traversals are counted for one policy at a time, not " +
                         std::to_string(policies.size()));
    if (threads.empty()) throw InputError("no number of threads given");
    for (const unsigned n : threads) {
        IntegratorOptions options;
        options.threads = n;
        options.superRayThreshold = superRayThreshold;
        options.validate();
    }
}

double meanOf(const std::vector<double>& values) {
    if (values.empty()) return 0;
    return std::accumulate(values.begin(), values.end(), 0.0) /
           static_cast<double>(values.size());
}

double medianOf(const std::vector<double>& values) {
    if (values.empty()) return 0;
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    const std::size_t half = sorted.size() / 2;
    return sorted.size() % 2 == 1 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half]);
}

std::vector<BenchRun> compareEngines(const PointScans& scans, double resolution,
                                     const CompareRequest& request, std::ostream& log,
                                     ProgressMeter::Style style) {
    std::vector<Contestant> all = makeContestants(scans, resolution, request);
    log << scans.name << ", " << resolution << " m: " << scans.scans.size() << " scans x "
        << all.size() << " engines" << std::endl;
    for (Contestant& c : all) {
        if (!request.peakMemory) break;
        log << "memory of " << c.run.engine << std::endl;
        measurePeak(c, scans);
    }
    for (Contestant& c : all) c.engine = c.info->make(c.options);
    const auto exact =
        std::find_if(all.begin(), all.end(), [](const auto& c) { return c.run.exact; });

    ProgressMeter meter(log, style);
    const Stopwatch total;
    BuildProgress progress;
    progress.totalScans = scans.scans.size() * all.size();
    for (std::size_t i = 0; i < scans.scans.size(); ++i) {
        const PointScan& scan = scans.scans[i];
        std::optional<VisitCount> needed;
        if (request.unnecessary && exact != all.end())
            needed = countVisits(scan, resolution, request.policies.front(),
                                 request.superRayThreshold, *exact->engine->saturation());
        for (std::size_t turn = 0; turn < all.size(); ++turn) {
            Contestant& c = all[i % 2 == 0 ? turn : all.size() - 1 - turn];
            insertTimed(c, scan);
            ++progress.scans;
            progress.rays += scan.points.size();
            progress.seconds = total.seconds();
            meter.update(progress);
        }
        if (needed) countUnnecessary(all, needed);
    }

    computeRatios(all);
    std::vector<BenchRun> runs;
    for (Contestant& c : all) {
        c.run.mapBytes = c.engine->mapBytes();
        c.run.digest = c.engine->digest();
        c.engine.reset();
        runs.push_back(std::move(c.run));
    }
    return runs;
}

std::vector<BenchRun> runCompare(
    const CompareRequest& request, std::ostream& log, ProgressMeter::Style style,
    const std::function<void(const std::vector<BenchRun>&)>& onRuns) {
    request.validate();
    std::vector<BenchRun> runs;
    for (const std::string& data : request.data) {
        const PointScans scans = loadPointScans({data, request.source, request.worldSeed});
        log << data << ": " << formatCount(scans.points) << " points in " << scans.scans.size()
            << " scans" << std::endl;
        for (const double resolution : request.resolutions) {
            auto more = compareEngines(scans, resolution, request, log, style);
            std::move(more.begin(), more.end(), std::back_inserter(runs));
            if (onRuns) onRuns(runs);
        }
    }
    return runs;
}

std::vector<std::string> digestConflicts(const std::vector<BenchRun>& runs) {
    using Key = std::tuple<std::string, double, std::string>;
    std::map<Key, std::map<std::string, std::string>> enginesByDigest;
    for (const BenchRun& run : runs) {
        if (!run.exact) continue;
        std::string& names =
            enginesByDigest[{run.data, run.resolution, run.policy}][run.digest];
        names += (names.empty() ? "" : ", ") + run.engine + " (threads " +
                 std::to_string(run.threads) + ")";
    }
    std::vector<std::string> conflicts;
    for (const auto& [key, digests] : enginesByDigest) {
        if (digests.size() == 1) continue;
        std::ostringstream line;
        line << "maps of " << std::get<0>(key) << " at " << std::get<1>(key) << " m, policy "
             << std::get<2>(key) << ", differ:";
        for (const auto& [digest, names] : digests)
            line << " " << digest << " by " << names << ";";
        conflicts.push_back(line.str());
    }
    return conflicts;
}

}  // namespace superray
