// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/stopwatch.h>
#include <superray/eval/input_error.h>
#include <superray/eval/realtime.h>
#include <superray/eval/seeded_random.h>

#include <cmath>
#include <ostream>

namespace superray {
namespace {

constexpr double kOccupied = 0.7, kFree = 0.3;  // the paper's
/// A single hit makes exactly 0.7, up to the rounding of an engine.
constexpr double kRounding = 1e-6;
constexpr float kCellsBeforeEnd = 2;

void test(const BenchEngine& engine, const TestPoint& point, RealtimeRun& run) {
    MapAccuracy& accuracy = point.occupied ? run.occupied : run.free;
    const auto p = engine.occupancy(point.point);
    ++accuracy.tested;
    if (!p)
        ++accuracy.unknown;
    else
        accuracy.correct += point.occupied ? *p > kOccupied + kRounding : *p < kFree;
}

}  // namespace

void RealtimeRequest::validate() const {
    if (!(rate > 0 && std::isfinite(rate)))
        throw InputError("the rate is " + std::to_string(rate) +
                         " scans a second; must be finite and > 0");
    if (!(testShare > 0 && testShare < 1))
        throw InputError("the share of test points is " + std::to_string(testShare) +
                         "; must be between 0 and 1");
    if (engines.empty()) throw InputError("no engines given");
    for (const std::string& name : engines) benchEngine(name);
    if (threads.empty()) throw InputError("no number of threads given");
    CellGeometry<3>{resolution};
    for (const unsigned n : threads) {
        IntegratorOptions options;
        options.threads = n;
        options.validate();
    }
}

std::vector<std::size_t> replayAtRate(std::size_t scans, double rate,
                                      const std::function<double(std::size_t)>& update) {
    std::vector<std::size_t> used;
    double busyUntil = 0;
    for (std::size_t i = 0; i < scans; ++i) {
        const double arrival = static_cast<double>(i) / rate;
        if (arrival < busyUntil) continue;
        busyUntil = arrival + update(i);
        used.push_back(i);
    }
    return used;
}

TrainTestSplit splitScans(const std::vector<PointScan>& scans, const RealtimeRequest& request) {
    const auto margin = kCellsBeforeEnd * static_cast<float>(request.resolution);
    TrainTestSplit split;
    for (std::size_t i = 0; i < scans.size(); ++i) {
        SeededRandom random(request.testSeed, i);
        PointScan training;
        training.origin = scans[i].origin;
        for (const Eigen::Vector3f& p : scans[i].points) {
            const bool tested = random.uniform() < request.testShare;
            if (!tested || request.training == TrainingPoints::all)
                training.points.push_back(p);
            if (!tested) continue;
            split.tests.push_back({p, true});
            const Eigen::Vector3f ray = p - scans[i].origin;
            const float length = ray.norm();
            if (length <= margin) continue;
            const auto t = static_cast<float>(random.uniform()) * (length - margin);
            split.tests.push_back({scans[i].origin + ray * (t / length), false});
        }
        split.training.push_back(std::move(training));
    }
    return split;
}

std::vector<RealtimeRun> runRealtime(const RealtimeRequest& request, std::ostream& log,
                                     ProgressMeter::Style style) {
    request.validate();
    const PointScans scans = loadPointScans({request.data, request.source, request.worldSeed});
    const TrainTestSplit split = splitScans(scans.scans, request);
    std::vector<RealtimeRun> runs;
    for (const std::string& name : request.engines) {
        const BenchEngineInfo& info = benchEngine(name);
        for (const unsigned threads :
             info.threaded ? request.threads : std::vector<unsigned>{1}) {
            log << name << ", " << threads << (threads == 1 ? " thread" : " threads")
                << std::endl;
            BenchEngineOptions options;
            options.resolution = request.resolution;
            options.threads = threads;
            options.policy = request.policy;
            options.bounds = scans.bounds;
            options.reserveMegabytes = request.reserveMegabytes;
            const auto engine = info.make(options);
            RealtimeRun run;
            run.engine = name;
            run.threads = threads;
            ProgressMeter meter(log, style);
            const Stopwatch total;
            BuildProgress progress;
            progress.totalScans = split.training.size();
            const auto used =
                replayAtRate(split.training.size(), request.rate, [&](std::size_t i) {
                    engine->prepare(split.training[i]);
                    const Stopwatch watch;
                    engine->insert();
                    const double seconds = watch.seconds();
                    run.updateMs.push_back(1e3 * seconds);
                    progress.scans = i + 1;
                    progress.rays += split.training[i].points.size();
                    progress.seconds = total.seconds();
                    meter.update(progress);
                    return seconds;
                });
            run.scansUsed = used.size();
            run.scansLost = split.training.size() - used.size();
            for (const TestPoint& point : split.tests) test(*engine, point, run);
            runs.push_back(std::move(run));
        }
    }
    return runs;
}

}  // namespace superray
