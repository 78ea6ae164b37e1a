// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/stopwatch.h>
#include <superray/eval/engine_weights.h>
#include <superray/eval/input_error.h>
#include <superray/eval/realtime.h>

#include <cmath>
#include <ostream>

namespace superray {

void RealtimeRequest::validate() const {
    if (!(rate > 0 && std::isfinite(rate)))
        throw InputError("the rate is " + std::to_string(rate) +
                         " scans a second; must be finite and > 0");
    if (engines.empty()) throw InputError("no engines given");
    for (const std::string& name : engines) benchEngine(name);
    if (threads.empty()) throw InputError("no number of threads given");
    split().validate();
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

std::vector<RealtimeRun> runRealtime(const RealtimeRequest& request, std::ostream& log,
                                     ProgressMeter::Style style) {
    request.validate();
    const PointScans scans = loadPointScans({request.data, request.source, request.worldSeed});
    const TrainTestSplit split = splitScans(scans.scans, request.split());
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
            options.peerModel = request.peerModel;
            options.bounds = scans.bounds;
            options.reserveMegabytes = request.reserveMegabytes;
            const auto engine = info.make(options);
            RealtimeRun run;
            run.engine = name;
            run.threads = threads;
            run.weights = describe(weightsOf(info, options));
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
            for (const TestPoint& t : split.tests)
                (t.occupied ? run.occupied : run.free)
                    .add(t.occupied, engine->occupancy(t.point));
            runs.push_back(std::move(run));
        }
    }
    return runs;
}

}  // namespace superray
