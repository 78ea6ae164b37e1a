// SPDX-License-Identifier: BSD-3-Clause
// superray-bench soak, in short.

#include <superray/eval/input_error.h>
#include <superray/eval/soak.h>
#include <superray/maps/map_factory.h>
#include <superray/storage/memory_limit_error.h>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

namespace superray {
namespace {

SoakRequest shortSoak() {
    SoakRequest request;
    request.data = "indoor";
    request.source.maxScans = 6;
    request.insertions = 240;
    request.pointsPerScan = 400;
    request.resolution = 0.25;
    request.windowRadius = 6;
    return request;
}

std::vector<SoakRun> run(const SoakRequest& request) {
    std::ostringstream log;
    return runSoak(request, log, ProgressMeter::Style::log);
}

TEST(Soak, MemoryIsFlatWithAWindow) {
    SoakRequest request = shortSoak();
    request.classes = mapClassNames();
    const auto runs = run(request);
    ASSERT_EQ(runs.size(), request.classes.size());
    for (const SoakRun& r : runs) {
        EXPECT_EQ(r.scans, 240u);
        ASSERT_EQ(r.samples.size(), kSoakSamples);
        EXPECT_EQ(r.samples.back().scans, 240u);
        EXPECT_GT(r.forgottenBlocks, 100u);
        EXPECT_GT(r.kilometres, 0.1);
        EXPECT_TRUE(isFlat(r)) << r.className;
    }
    const auto json = nlohmann::json::parse(soakAsJson(request, runs));
    EXPECT_EQ(json["runs"].size(), runs.size());
    EXPECT_TRUE(json["runs"][0]["flat"]);
    EXPECT_NE(soakAsText(request, runs).find("memory is flat"), std::string::npos);
}

TEST(Soak, MemoryGrowsWithoutAWindow) {
    SoakRequest request = shortSoak();
    request.windowRadius = 0;
    const auto runs = run(request);
    EXPECT_FALSE(isFlat(runs.at(0)));
    EXPECT_EQ(runs.at(0).forgottenBlocks, 0u);
    EXPECT_NE(soakAsText(request, runs).find("GROWS"), std::string::npos);
    request.maxMemoryMegabytes = 1;
    EXPECT_THROW(run(request), MemoryLimitError);
}

TEST(Soak, JudgesTheHighestAfterTheWindowHasFilled) {
    std::vector<std::uint64_t> values(40, 1000);
    values[3] = 5000;  // before the window is full
    EXPECT_TRUE(isFlat(values, 0));
    values[39] = 1050;
    EXPECT_TRUE(isFlat(values, 0));
    values[39] = 1051;
    EXPECT_FALSE(isFlat(values, 0));
    EXPECT_TRUE(isFlat(values, 1));
    values[10] = 1100;
    EXPECT_TRUE(isFlat(values, 0));
    EXPECT_FALSE(isFlat(std::vector<std::uint64_t>(5, 1), 0)) << "nothing to judge";
}

TEST(Soak, RefusesBadRequests) {
    SoakRequest request = shortSoak();
    request.insertions = 39;
    EXPECT_THROW(run(request), InputError);
    request = shortSoak();
    request.windowRadius = -1;
    EXPECT_THROW(run(request), std::invalid_argument);
    request = shortSoak();
    request.classes = {"CNoMap"};
    EXPECT_THROW(run(request), std::invalid_argument);
    request = shortSoak();
    request.resolution = 0.0005;  // a few metres can be addressed
    EXPECT_THROW(run(request), InputError);
}

}  // namespace
}  // namespace superray
