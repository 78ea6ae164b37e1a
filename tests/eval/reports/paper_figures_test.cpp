// SPDX-License-Identifier: BSD-3-Clause
// The paper's tables and figures: complete, consistent, drawable.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>
#include <superray/eval/paper_figures.h>

#include <cstdlib>
#include <map>
#include <sstream>

#include "eval/engines/bench_scans.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;
using Rows = std::vector<std::map<std::string, std::string>>;

/// Rows by column name (no field of these files needs quotes).
Rows parse(const std::string& csv) {
    std::istringstream lines(csv);
    std::string line;
    std::vector<std::string> heading;
    Rows rows;
    while (std::getline(lines, line)) {
        std::vector<std::string> fields;
        std::string field;
        for (const char c : line + ",") {
            if (c != ',') {
                field += c;
                continue;
            }
            fields.push_back(field);
            field.clear();
        }
        if (heading.empty()) {
            heading = fields;
            continue;
        }
        EXPECT_EQ(fields.size(), heading.size()) << line;
        std::map<std::string, std::string> row;
        for (std::size_t i = 0; i < std::min(heading.size(), fields.size()); ++i)
            row[heading[i]] = fields[i];
        rows.push_back(row);
    }
    return rows;
}

PaperRequest smallRequest(const TempFolder& folder) {
    PaperRequest request;
    request.data = writeSmallRecording(folder / "small.rawlog");
    request.resolutions = {0.2, 0.5};
    request.thresholds = {2, 20};
    request.peakMemory = false;
    return request;
}

PaperRuns run(const PaperRequest& request) {
    std::ostringstream log;
    return runPaper(request, log, ProgressMeter::Style::log);
}

TEST(Paper, tablesHoldEveryEngineAndResolution) {
    TempFolder folder;
    const PaperRuns runs = run(smallRequest(folder));
    std::map<std::string, Rows> files;
    for (const NamedText& file : paperTables(runs)) files[file.name] = parse(file.text);
    ASSERT_EQ(files.size(), 7u);
    for (const char* name : {"table2_update_time.csv", "table3_traversals.csv",
                             "table4_memory.csv", "fig10_speedup.csv", "fig12_stages.csv"})
        EXPECT_EQ(files[name].size(), 22u) << name;  // 11 engines, 2 resolutions
    EXPECT_EQ(files["fig15_scans.csv"].size(), 66u);
    EXPECT_EQ(files["fig11_threshold.csv"].size(), 16u);  // 4 engines, 2 k, 2 resolutions

    int walked = 0;
    std::map<std::string, double> traversed;
    for (auto& row : files["table3_traversals.csv"]) {
        EXPECT_EQ(row["rays_per_scan"], "300");
        if (row["engine"] == "octomap") {
            EXPECT_EQ(row["traversed_per_scan"], "");
            continue;
        }
        ++walked;
        const double share = std::stod(row["unnecessary_share"]);
        EXPECT_GE(share, 0);
        EXPECT_LE(share, 1);
        traversed[row["engine"] + row["resolution_m"]] = std::stod(row["traversed_per_scan"]);
    }
    EXPECT_EQ(walked, 20);
    EXPECT_LE(traversed["grid-culling0.5"], traversed["grid-perRay0.5"]);
    EXPECT_LE(traversed["octree-full0.5"], traversed["octree-superRays0.5"]);
    for (auto& row : files["fig10_speedup.csv"])
        EXPECT_TRUE(row["engine"] != "grid-perRay" || row["over_perRay"] == "1");
    for (auto& row : files["fig12_stages.csv"]) {
        if (row["engine"] == "octomap") continue;
        double sum = 0;
        for (const char* stage :
             {"to_rays_ms", "super_rays_ms", "culling_ms", "traversal_ms", "apply_ms"})
            sum += std::stod(row[stage]);
        EXPECT_LE(sum, 1.001 * std::stod(row["total_ms"])) << row["engine"];
    }
}

TEST(Paper, writesFilesAndDrawsThem) {
    TempFolder folder;
    auto request = smallRequest(folder);
    request.engines = {"octomap", "grid-superRays", "grid-perRay"};
    const PaperRuns runs = run(request);
    const std::string out = folder / "a/paper";
    const bool drawn = writePaper(runs, out);
    for (const NamedText& table : paperTables(runs))
        EXPECT_EQ(readWholeFile(out + "/" + table.name), table.text);
    const auto plots = paperPlots(runs);
    EXPECT_EQ(plots.size(), 7u);  // one of Fig. 10; 11, 12 and 15 for each resolution
    for (const NamedText& plot : plots) {
        EXPECT_EQ(readWholeFile(out + "/" + plot.name), plot.text);
        const std::string picture = plot.name.substr(0, plot.name.size() - 3) + ".png";
        EXPECT_NE(plot.text.find("'" + picture + "'"), std::string::npos);
        EXPECT_TRUE(!drawn || std::filesystem::file_size(out + "/" + picture) > 5000)
            << picture;
    }
    EXPECT_EQ(drawn, std::system("command -v gnuplot >/dev/null") == 0);
    folder.write("file", "not a folder");
    EXPECT_THROW(writePaper(runs, folder / "file"), InputError);
}

TEST(Paper, withoutSuperRaysThereIsNoThresholdFigure) {
    TempFolder folder;
    auto request = smallRequest(folder);
    request.engines = {"grid"};
    request.resolutions = {0.5};
    const PaperRuns runs = run(request);
    EXPECT_TRUE(runs.overThreshold.empty());
    EXPECT_EQ(paperPlots(runs).size(), 2u);  // stages and scans: no octomap to be faster than
}

}  // namespace
}  // namespace superray
