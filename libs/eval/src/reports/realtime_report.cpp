// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/bench_compare.h>
#include <superray/eval/realtime.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "text/text_table.h"

namespace superray {
namespace {

double largest(const std::vector<double>& values) {
    return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

std::string percent(double share) {
    return formatFixed(100 * share, 1) + " %";
}

nlohmann::ordered_json asJson(const ClassScore& a) {
    return {{"tested", a.tested},
            {"correct", a.right},
            {"correct_at_half", a.rightAtHalf},
            {"unknown", a.unknown}};
}

}  // namespace

std::string realtimeAsText(const RealtimeRequest& request,
                           const std::vector<RealtimeRun>& runs) {
    std::ostringstream out;
    out << request.data << ", " << request.resolution << " m, " << request.rate
        << " scans a second; maps of "
        << (request.training == TrainingPoints::all
                ? "all points"
                : percent(1 - request.testShare) + " of the points")
        << "; grid and octree take " << request.reserveMegabytes
        << " MB before the first scan\n";
    TextTable table({"engine", "threads", "used", "lost", "mean ms", "max ms", "accuracy",
                     "occupied", "free"});
    for (const RealtimeRun& run : runs)
        table.add({run.engine, std::to_string(run.threads), std::to_string(run.scansUsed),
                   std::to_string(run.scansLost), formatShort(meanOf(run.updateMs)),
                   formatShort(largest(run.updateMs)), percent(run.all().share()),
                   percent(run.occupied.share()), percent(run.free.share())});
    out << table.text()
        << "\nused, lost: scans. accuracy: share of test points with p > 0.7 (occupied) or\n"
           "p < 0.3 (free); unknown ones count as wrong.\n"
           "What rays really do to a cell:\n";
    std::string told;
    for (const RealtimeRun& run : runs)
        if (run.engine != told) {
            out << "  " << run.engine << ": " << run.weights << "\n";
            told = run.engine;
        }
    return out.str();
}

std::string realtimeAsJson(const RealtimeRequest& request,
                           const std::vector<RealtimeRun>& runs) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const RealtimeRun& run : runs)
        list.push_back({{"data", request.data},
                        {"resolution", request.resolution},
                        {"rate", request.rate},
                        {"all_points", request.training == TrainingPoints::all},
                        {"policy", toString(request.policy)},
                        {"reserve_megabytes", request.reserveMegabytes},
                        {"engine", run.engine},
                        {"weights", run.weights},
                        {"threads", run.threads},
                        {"scans_used", run.scansUsed},
                        {"scans_lost", run.scansLost},
                        {"mean_ms", meanOf(run.updateMs)},
                        {"max_ms", largest(run.updateMs)},
                        {"accuracy", run.all().share()},
                        {"occupied", asJson(run.occupied)},
                        {"free", asJson(run.free)}});
    const nlohmann::ordered_json document = {{"program", "superray-bench realtime"},
                                             {"runs", list}};
    return document.dump(2) + "\n";
}

}  // namespace superray
