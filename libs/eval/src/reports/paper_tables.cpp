// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/paper_figures.h>

#include <algorithm>
#include <numeric>

#include "text/text_table.h"

namespace superray {
namespace {

/// Comma-separated values, quoted where need be.
class Csv {
 public:
    explicit Csv(const std::vector<std::string>& heading) { row(heading); }
    void row(const std::vector<std::string>& fields) {
        for (std::size_t i = 0; i < fields.size(); ++i)
            text_ += (i > 0 ? "," : "") + quoted(fields[i]);
        text_ += "\n";
    }
    const std::string& text() const { return text_; }

 private:
    static std::string quoted(const std::string& field) {
        if (field.find_first_of(",\"\n") == std::string::npos) return field;
        std::string result = "\"";
        for (const char c : field) result += c == '"' ? std::string("\"\"") : std::string{c};
        return result + "\"";
    }
    std::string text_;
};

using Fields = std::vector<std::string>;

std::string number(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}
std::string number(std::uint64_t value) {
    return std::to_string(value);
}

/// What run this is: the first columns of every table.
const Fields kKey = {"data", "resolution_m", "engine", "threads", "scans"};
Fields key(const BenchRun& run) {
    return {run.data, number(run.resolution), run.engine, std::to_string(run.threads),
            number(run.scans)};
}
Fields joined(Fields a, const Fields& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

/// One row for each run.
template <class Columns>
std::string table(const std::vector<BenchRun>& runs, const Fields& heading,
                  const Columns& columns) {
    Csv csv(joined(kKey, heading));
    for (const BenchRun& run : runs) csv.row(joined(key(run), columns(run)));
    return csv.text();
}

double perScan(std::uint64_t count, const BenchRun& run) {
    return static_cast<double>(count) / static_cast<double>(run.scans);
}

/// The same map with every ray walked; nullptr if it was not run.
const BenchRun* baselineOf(const BenchRun& run, const std::vector<BenchRun>& runs) {
    const std::string map = run.engine.substr(0, run.engine.find('-'));
    for (const BenchRun& other : runs)
        if (other.engine == map + "-perRay" && other.resolution == run.resolution &&
            other.threads == run.threads)
            return &other;
    return nullptr;
}

}  // namespace

std::vector<NamedText> paperTables(const PaperRuns& all) {
    const auto& runs = all.compared;
    std::vector<NamedText> files;
    files.push_back({"table2_update_time.csv",
                     table(runs, {"mean_ms", "median_ms", "cpu_mean_ms", "ratio_to_octomap"},
                           [](const BenchRun& r) -> Fields {
                               return {number(meanOf(r.wallMs)), number(medianOf(r.wallMs)),
                                       number(meanOf(r.cpuMs)),
                                       r.ratioToOctomap ? number(*r.ratioToOctomap) : ""};
                           })});
    files.push_back({"table3_traversals.csv",
                     table(runs,
                           {"rays_per_scan", "super_rays_per_scan", "traversed_per_scan",
                            "unnecessary_per_scan", "unnecessary_share"},
                           [](const BenchRun& r) -> Fields {
                               const auto& w = r.work;
                               const bool tells = w.traversedCells > 0;
                               if (!tells)
                                   return {number(perScan(r.points, r)), "", "", "", ""};
                               const std::uint64_t unnecessary = r.unnecessaryCells.value_or(0);
                               return {number(perScan(r.points, r)),
                                       number(perScan(w.superRays, r)),
                                       number(perScan(w.traversedCells, r)),
                                       number(perScan(unnecessary, r)),
                                       number(static_cast<double>(unnecessary) /
                                              static_cast<double>(w.traversedCells))};
                           })});
    files.push_back({"table4_memory.csv",
                     table(runs, {"map_bytes", "peak_bytes"}, [](const BenchRun& r) -> Fields {
                         return {number(r.mapBytes), r.peakBytes ? number(*r.peakBytes) : ""};
                     })});
    files.push_back(
        {"fig10_speedup.csv",
         table(runs, {"mean_ms", "over_octomap", "over_perRay"},
               [&](const BenchRun& r) -> Fields {
                   const BenchRun* base = baselineOf(r, runs);
                   return {
                       number(meanOf(r.wallMs)),
                       r.ratioToOctomap ? number(*r.ratioToOctomap) : "",
                       base ? number(meanOf(comparedMs(*base)) / meanOf(comparedMs(r))) : ""};
               })});
    Csv overK(joined({"k"}, joined(kKey, {"mean_ms", "super_rays_share"})));
    for (const auto& [k, runsAtK] : all.overThreshold)
        for (const BenchRun& r : runsAtK)
            overK.row(joined({std::to_string(k)},
                             joined(key(r), {number(meanOf(comparedMs(r))),
                                             number(static_cast<double>(r.work.superRays) /
                                                    static_cast<double>(r.points))})));
    files.push_back({"fig11_threshold.csv", overK.text()});
    files.push_back(
        {"fig12_stages.csv",
         table(runs,
               {"to_rays_ms", "super_rays_ms", "culling_ms", "traversal_ms", "apply_ms",
                "total_ms"},
               [](const BenchRun& r) -> Fields {
                   const auto& w = r.work;
                   const double total = meanOf(r.wallMs);
                   if (w.toRaysSeconds == 0) return {"", "", "", "", "", number(total)};
                   Fields fields;
                   for (const double s : {w.toRaysSeconds, w.superRaySeconds, w.cullingSeconds,
                                          w.traversalSeconds, w.applySeconds})
                       fields.push_back(number(1e3 * s / static_cast<double>(r.scans)));
                   fields.push_back(number(total));
                   return fields;
               })});
    Csv overScans(joined(kKey, {"scan", "ms", "traversed", "culling_cells"}));
    for (const BenchRun& r : runs)
        for (std::size_t i = 0; i < comparedMs(r).size(); ++i) {
            const BenchWork& w = r.workOfScan[i];
            const bool tells = r.work.traversedCells > 0;
            overScans.row(joined(key(r), {std::to_string(i), number(comparedMs(r)[i]),
                                          tells ? number(w.traversedCells) : "",
                                          tells ? number(w.cullingCells) : ""}));
        }
    files.push_back({"fig15_scans.csv", overScans.text()});
    return files;
}

}  // namespace superray
