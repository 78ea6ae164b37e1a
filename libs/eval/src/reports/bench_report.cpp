// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/processors.h>
#include <superray/eval/bench_compare.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "text/text_table.h"

namespace superray {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json orNull(const std::optional<T>& value) {
    return value ? Json(*value) : Json(nullptr);
}

double otherSeconds(const BenchRun& run) {
    double total = 0;
    for (const double ms : run.wallMs) total += 1e-3 * ms;
    const BenchWork& w = run.work;
    return total - w.toRaysSeconds - w.superRaySeconds - w.cullingSeconds - w.traversalSeconds -
           w.applySeconds;
}

bool tellsStages(const BenchRun& run) {
    return run.work.toRaysSeconds > 0;
}

Json stagesOf(const BenchRun& run) {
    if (!tellsStages(run)) return nullptr;
    const BenchWork& w = run.work;
    return {{"to_rays", w.toRaysSeconds},  {"super_rays", w.superRaySeconds},
            {"culling", w.cullingSeconds}, {"traversal", w.traversalSeconds},
            {"apply", w.applySeconds},     {"other", otherSeconds(run)}};
}

/// "4 1 8 80 7": percent of the time by stage.
std::string stageShares(const BenchRun& run) {
    if (!tellsStages(run)) return "-";
    double total = 0;
    for (const double ms : run.wallMs) total += 1e-3 * ms;
    const BenchWork& w = run.work;
    std::string text;
    for (const double seconds : {w.toRaysSeconds, w.superRaySeconds, w.cullingSeconds,
                                 w.traversalSeconds, w.applySeconds})
        text += (text.empty() ? "" : " ") + formatFixed(100 * seconds / total, 0);
    return text;
}

std::string millions(std::uint64_t count) {
    return formatShort(1e-6 * static_cast<double>(count));
}

std::string perScan(std::uint64_t count, const BenchRun& run) {
    return millions(count / std::max<std::uint64_t>(run.scans, 1));
}

}  // namespace

std::string runsAsJson(const std::vector<BenchRun>& runs) {
    Json list = Json::array();
    for (const BenchRun& run : runs) {
        const BenchWork& w = run.work;
        const bool tells = w.traversedCells > 0;
        list.push_back({{"data", run.data},
                        {"resolution", run.resolution},
                        {"engine", run.engine},
                        {"threads", run.threads},
                        {"policy", run.policy},
                        {"exact", run.exact},
                        {"scans", run.scans},
                        {"rays", run.points},
                        {"ms_per_scan", meanOf(run.wallMs)},
                        {"median_ms", medianOf(run.wallMs)},
                        {"cpu_ms_per_scan", meanOf(run.cpuMs)},
                        {"cpu_median_ms", medianOf(run.cpuMs)},
                        {"ratio_to_octomap", orNull(run.ratioToOctomap)},
                        {"ratio_clock", run.threads == 1 ? "cpu" : "wall"},
                        {"map_bytes", run.mapBytes},
                        {"peak_bytes", orNull(run.peakBytes)},
                        {"digest", run.digest.empty() ? Json(nullptr) : Json(run.digest)},
                        {"super_rays", tells ? Json(w.superRays) : Json(nullptr)},
                        {"traversed_cells", tells ? Json(w.traversedCells) : Json(nullptr)},
                        {"unnecessary_cells", tells ? orNull(run.unnecessaryCells) : nullptr},
                        {"culling_cells", tells ? Json(w.cullingCells) : Json(nullptr)},
                        {"touched_blocks", tells ? Json(w.touchedBlocks) : Json(nullptr)},
                        {"stage_seconds", stagesOf(run)}});
    }
    const Json document = {{"program", "superray-bench compare"},
                           {"hardware_threads", availableProcessors()},
                           {"runs", list}};
    return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string runsAsText(const std::vector<BenchRun>& runs) {
    std::ostringstream out;
    for (std::size_t i = 0; i < runs.size();) {
        const BenchRun& first = runs[i];
        out << "\n"
            << first.data << ", " << first.resolution << " m, " << first.scans << " scans, "
            << formatCount(first.points / first.scans) << " points a scan\n";
        TextTable table({"engine", "threads", "policy", "ms/scan", "median", "cpu", "ratio",
                         "map", "peak", "super rays", "cells", "unnecessary", "stages %",
                         "digest"});
        for (; i < runs.size() && runs[i].data == first.data &&
               runs[i].resolution == first.resolution;
             ++i) {
            const BenchRun& run = runs[i];
            const bool tells = run.work.traversedCells > 0;
            table.add(
                {run.engine, std::to_string(run.threads), run.policy,
                 formatShort(meanOf(run.wallMs)), formatShort(medianOf(run.wallMs)),
                 formatShort(meanOf(run.cpuMs)),
                 run.ratioToOctomap ? formatShort(*run.ratioToOctomap) : "-",
                 formatBytes(run.mapBytes), run.peakBytes ? formatBytes(*run.peakBytes) : "-",
                 tells ? perScan(run.work.superRays, run) : "-",
                 tells ? perScan(run.work.traversedCells, run) : "-",
                 tells && run.unnecessaryCells ? perScan(*run.unnecessaryCells, run) : "-",
                 stageShares(run), run.digest.empty() ? "-" : run.digest.substr(0, 8)});
        }
        out << table.text();
    }
    out << "\nms/scan, median: elapsed; cpu: processor time of all threads, mean. ratio: "
           "octomap's\n"
           "total time / this engine's (cpu with one thread, elapsed with several).\n"
           "super rays, cells (traversed), unnecessary: millions a scan. stages: points to "
           "rays,\n"
           "super rays, culling region, traversal, apply.\n";
    return out.str();
}

}  // namespace superray
