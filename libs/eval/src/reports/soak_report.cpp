// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/soak.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "text/text_table.h"

namespace superray {

std::string soakAsText(const SoakRequest& request, const std::vector<SoakRun>& runs) {
    std::ostringstream out;
    out << request.data << ", " << request.resolution << " m, ";
    if (request.windowRadius > 0)
        out << "window of " << request.windowRadius << " m";
    else
        out << "no window";
    if (request.maxMemoryMegabytes > 0)
        out << ", bound of " << request.maxMemoryMegabytes << " MB";
    out << "\n";
    for (const SoakRun& run : runs) {
        out << "\n"
            << run.className << ": " << formatCount(run.scans) << " scans in "
            << formatSeconds(run.seconds) << ", " << formatFixed(run.kilometres, 1) << " km, "
            << formatCount(run.forgottenBlocks) << " blocks forgotten\n";
        TextTable table({"scans", "scans/s", "map", "process"});
        for (std::size_t i = 3; i < run.samples.size(); i += 4) {
            const SoakSample& s = run.samples[i];
            table.add({formatCount(s.scans), formatShort(s.scansPerSecond),
                       formatBytes(s.heldBytes), formatBytes(s.residentBytes)});
        }
        out << table.text() << "memory " << (isFlat(run) ? "is flat" : "GROWS")
            << " after the first " << formatCount(run.samples[kSoakFilled - 1].scans)
            << " scans\n";
    }
    return out.str();
}

std::string soakAsJson(const SoakRequest& request, const std::vector<SoakRun>& runs) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const SoakRun& run : runs) {
        nlohmann::ordered_json samples = nlohmann::ordered_json::array();
        for (const SoakSample& s : run.samples)
            samples.push_back({{"scans", s.scans},
                               {"scans_per_second", s.scansPerSecond},
                               {"held_bytes", s.heldBytes},
                               {"resident_bytes", s.residentBytes}});
        list.push_back({{"class", run.className},
                        {"scans", run.scans},
                        {"seconds", run.seconds},
                        {"kilometres", run.kilometres},
                        {"forgotten_blocks", run.forgottenBlocks},
                        {"flat", isFlat(run)},
                        {"samples", samples}});
    }
    const nlohmann::ordered_json document = {
        {"program", "superray-bench soak"},
        {"data", request.data},
        {"resolution", request.resolution},
        {"window_radius", request.windowRadius},
        {"max_memory_megabytes", request.maxMemoryMegabytes},
        {"points_per_scan", request.pointsPerScan},
        {"threads", request.threads},
        {"runs", list}};
    return document.dump(2) + "\n";
}

}  // namespace superray
