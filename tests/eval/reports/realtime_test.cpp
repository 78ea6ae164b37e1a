// SPDX-License-Identifier: BSD-3-Clause
// The navigation scenario: who is lost, who tests, and how accuracy is counted.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>
#include <superray/eval/realtime.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "eval/engines/bench_scans.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;
using Numbers = std::vector<std::size_t>;

TEST(Replay, losesScansThatArriveWhileBusy) {
    const auto taking = [](double seconds) { return [=](std::size_t) { return seconds; }; };
    EXPECT_EQ(replayAtRate(5, 10, taking(0.01)), (Numbers{0, 1, 2, 3, 4}));
    EXPECT_EQ(replayAtRate(5, 10, taking(0.15)), (Numbers{0, 2, 4}));
    EXPECT_EQ(replayAtRate(7, 10, taking(0.25)), (Numbers{0, 3, 6}));
    EXPECT_EQ(replayAtRate(5, 10, taking(100)), (Numbers{0}));
    EXPECT_EQ(replayAtRate(0, 10, taking(1)), Numbers{});
    // Only a slow update costs scans.
    EXPECT_EQ(replayAtRate(6, 1, [](std::size_t i) { return i == 1 ? 2.5 : 0.5; }),
              (Numbers{0, 1, 4, 5}));
}

RealtimeRequest smallRequest(const TempFolder& folder) {
    RealtimeRequest request;
    request.data = writeSmallRecording(folder / "small.rawlog");
    request.engines = {"grid", "octomap"};
    request.rate = 1e-3;
    return request;
}

TEST(Split, partsPointsAndDrawsFreeOnes) {
    TempFolder folder;
    auto request = smallRequest(folder);
    const PointScans scans = smallScans(folder / "");
    const TrainTestSplit split = splitScans(scans.scans, request.split());
    ASSERT_EQ(split.training.size(), 3u);
    std::size_t training = 0, ends = 0, free = 0;
    for (const PointScan& scan : split.training) training += scan.points.size();
    for (const TestPoint& t : split.tests) (t.occupied ? ends : free) += 1;
    EXPECT_EQ(training + ends, 900u);
    EXPECT_NEAR(static_cast<double>(ends), 180, 50);
    EXPECT_GT(free, ends * 8 / 10);
    EXPECT_LE(free, ends);
    // A free point lies on the ray of the end point before it, two cells away.
    const TestPoint* end = nullptr;
    std::size_t checked = 0;
    for (const TestPoint& t : split.tests) {
        if (t.occupied) {
            end = &t;
            continue;
        }
        EXPECT_GE((end->point - t.point).norm(), 2 * 0.2f - 1e-4f);
        float beside = 1e9f;
        for (const PointScan& scan : scans.scans)
            beside = std::min(beside, (t.point - scan.origin).norm() +
                                          (end->point - t.point).norm() -
                                          (end->point - scan.origin).norm());
        EXPECT_LT(beside, 1e-4f);
        ++checked;
    }
    EXPECT_EQ(checked, free);

    request.training = TrainingPoints::all;
    const TrainTestSplit all = splitScans(scans.scans, request.split());
    EXPECT_EQ(all.tests.size(), split.tests.size());
    EXPECT_EQ(all.training[1].points.size(), 300u);
    request.testSeed = 2;
    EXPECT_NE(splitScans(scans.scans, request.split()).tests[0].point, split.tests[0].point);
}

TEST(Realtime, ReservesMemoryOfOurMaps) {
    BenchEngineOptions options;
    options.reserveMegabytes = 64;
    for (const char* name : {"grid", "octree"}) {
        const std::size_t bytes = benchEngine(name).make(options)->mapBytes();
        EXPECT_GT(bytes, 40u << 20) << name;
        EXPECT_LT(bytes, 64u << 20) << name;
    }
}

/// Knows what the test says it knows.
class Oracle final : public BenchEngine {
 public:
    explicit Oracle(std::optional<double> answer) : answer_(answer) {}
    void prepare(const PointScan&) override {}
    void insert() override {}
    std::size_t mapBytes() const override { return 1; }
    std::optional<double> occupancy(const Eigen::Vector3f&) const override { return answer_; }

 private:
    std::optional<double> answer_;
};

TEST(Realtime, countsAccuracyAtThePapersThresholds) {
    const auto add = [](const std::string& name, std::optional<double> answer) {
        addBenchEngine({name, "for this test", false, "", false,
                        [=](const auto&) { return std::make_unique<Oracle>(answer); }});
    };
    add("always-0.71", 0.71);
    add("always-0.7", 0.7);
    add("always-0.3", 0.3);
    add("always-0.29", 0.29);
    add("unknown", std::nullopt);
    TempFolder folder;
    auto request = smallRequest(folder);
    request.engines = {"always-0.71", "always-0.7", "always-0.3", "always-0.29", "unknown"};
    std::ostringstream log;
    const auto runs = runRealtime(request, log, ProgressMeter::Style::log);
    ASSERT_EQ(runs.size(), 5u);
    const double occupied[] = {1, 0, 0, 0, 0}, free[] = {0, 0, 0, 1, 0};
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_GT(runs[i].occupied.tested, 100u);
        EXPECT_EQ(runs[i].occupied.share(), occupied[i]) << i;
        EXPECT_EQ(runs[i].free.share(), free[i]) << i;
        EXPECT_EQ(runs[i].all().unknown, i == 4 ? runs[i].all().tested : 0u);
    }
}

TEST(Realtime, slowScansUseAllAndQuickOnesFew) {
    TempFolder folder;
    auto request = smallRequest(folder);
    request.threads = {1, 2};
    std::ostringstream log;
    const auto all = runRealtime(request, log, ProgressMeter::Style::log);
    ASSERT_EQ(all.size(), 3u);
    for (const RealtimeRun& run : all) {
        EXPECT_EQ(run.scansUsed, 3u);
        EXPECT_EQ(run.scansLost, 0u);
        EXPECT_EQ(run.updateMs.size(), 3u);
        EXPECT_GT(run.free.share(), 0.02) << run.engine;
    }
    EXPECT_EQ(all[0].all().right, all[1].all().right);  // threads change nothing
    request.rate = 1e9;
    for (const RealtimeRun& run : runRealtime(request, log, ProgressMeter::Style::log)) {
        EXPECT_EQ(run.scansUsed, 1u);
        EXPECT_EQ(run.scansLost, 2u);
    }
    const auto json = nlohmann::json::parse(realtimeAsJson(request, all));
    ASSERT_EQ(json["runs"].size(), 3u);
    EXPECT_EQ(json["runs"][0]["scans_used"], 3);
    EXPECT_EQ(json["runs"][0]["accuracy"], all[0].all().share());
    EXPECT_NE(realtimeAsText(request, all).find("octomap"), std::string::npos);
}

TEST(Realtime, refusesBadRequests) {
    TempFolder folder;
    const auto message = [&](const auto& change) {
        auto request = smallRequest(folder);
        change(request);
        std::ostringstream log;
        return messageOf<std::exception>(
            [&] { runRealtime(request, log, ProgressMeter::Style::log); });
    };
    EXPECT_NE(message([](auto& r) { r.rate = 0; }).find("rate"), std::string::npos);
    EXPECT_NE(message([](auto& r) { r.engines = {"gird"}; }).find("gird"), std::string::npos);
    EXPECT_NE(message([](auto& r) { r.testShare = 1; }).find("share"), std::string::npos);
    EXPECT_NE(message([](auto& r) { r.threads = {0}; }).find("threads"), std::string::npos);
    EXPECT_NE(message([](auto& r) { r.resolution = -1; }).find("resolution"),
              std::string::npos);
}

}  // namespace
}  // namespace superray
