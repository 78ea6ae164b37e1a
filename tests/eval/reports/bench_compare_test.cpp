// SPDX-License-Identifier: BSD-3-Clause
// The comparison: its numbers, its JSON, and that unequal maps do not pass.

#include <gtest/gtest.h>
#include <superray/core/detail/sanitizers.h>
#include <superray/core/traversal.h>
#include <superray/eval/bench_compare.h>
#include <superray/eval/input_error.h>

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "eval/engines/bench_scans.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;

CompareRequest smallRequest(const TempFolder& folder) {
    CompareRequest request;
    request.data = {writeSmallRecording(folder / "small.rawlog")};
    request.resolutions = {0.2, 0.5};
    request.engines = {"octomap", "mrpt-octomap",   "mrpt-grid3d",
                       "grid",    "octree-culling", "grid-reference"};
    request.threads = {1, 2};
    return request;
}

std::vector<BenchRun> run(const CompareRequest& request) {
    std::ostringstream log;
    std::vector<std::size_t> soFar;
    auto runs = runCompare(request, log, ProgressMeter::Style::log,
                           [&](const auto& some) { soFar.push_back(some.size()); });
    EXPECT_EQ(soFar.size(), request.data.size() * request.resolutions.size());
    EXPECT_EQ(soFar.back(), runs.size());
    EXPECT_NE(log.str().find("points in"), std::string::npos) << log.str();
    return runs;
}

TEST(Compare, runsEveryEngineThreadCountAndResolution) {
    TempFolder folder;
    auto request = smallRequest(folder);
    request.peakMemory = true;
    const auto runs = run(request);
    // Three peers with one thread, three of ours with one and two; two resolutions.
    ASSERT_EQ(runs.size(), 18u);
    for (const BenchRun& r : runs) {
        EXPECT_EQ(r.data, "small");
        EXPECT_EQ(r.scans, 3u);
        EXPECT_EQ(r.points, 900u);
        ASSERT_EQ(r.wallMs.size(), 3u);
        ASSERT_EQ(r.cpuMs.size(), 3u);
        EXPECT_GT(meanOf(r.wallMs), 0);
        EXPECT_GT(r.mapBytes, 0u);
        ASSERT_TRUE(r.ratioToOctomap.has_value());
        EXPECT_GT(*r.ratioToOctomap, 0);
        EXPECT_TRUE(r.engine != "octomap" || *r.ratioToOctomap == 1);
        EXPECT_EQ(r.policy, r.engine.rfind("mrpt-grid3d", 0) == 0 ? "rayByRay"
                            : r.exact                             ? "netEvidence"
                                                                  : "oncePerScan");
    }
    EXPECT_TRUE(digestConflicts(runs).empty());
}

/// Holds what it is told to, and more for a moment.
class Hoarder final : public BenchEngine {
 public:
    static constexpr std::size_t kKept = 40'000'000, kForAMoment = 80'000'000;  // bytes
    void prepare(const PointScan&) override {}
    void insert() override {
        if (kept_.empty()) kept_.assign(kKept, 'k');
        const std::vector<char> moment(kForAMoment, 'm');
        EXPECT_EQ(moment.back(), 'm');
    }
    std::size_t mapBytes() const override { return kept_.size(); }
    std::optional<double> occupancy(const Eigen::Vector3f&) const override { return {}; }

 private:
    std::vector<char> kept_;
};

TEST(Compare, peakMemoryIsThatOfTheEngineAlone) {
    if (kSanitized) GTEST_SKIP() << "SANITIZERS KEEP FREED MEMORY: PEAK NOT TESTED";
    addBenchEngine({"hoarder", "for this test", false, "", false,
                    [](const auto&) { return std::make_unique<Hoarder>(); }});
    TempFolder folder;
    auto request = smallRequest(folder);
    request.engines = {"hoarder", "grid"};
    request.resolutions = {0.5};
    request.threads = {1};
    request.peakMemory = true;
    const auto runs = run(request);
    ASSERT_EQ(runs.size(), 2u);
    ASSERT_TRUE(runs[0].peakBytes.has_value());
    EXPECT_GT(*runs[0].peakBytes, Hoarder::kKept + Hoarder::kForAMoment);
    EXPECT_LT(*runs[0].peakBytes, Hoarder::kKept + Hoarder::kForAMoment + 20'000'000);
    EXPECT_LT(runs[1].peakBytes.value_or(0), 20'000'000u);
}

TEST(Compare, jsonHasTheFieldsThatAreDocumented) {
    TempFolder folder;
    const auto request = smallRequest(folder);
    const auto runs = run(request);
    const auto document = nlohmann::json::parse(runsAsJson(runs));
    ASSERT_EQ(document["runs"].size(), runs.size());
    std::size_t i = 0;
    for (const auto& json : document["runs"]) {
        const BenchRun& r = runs[i++];
        EXPECT_EQ(json["data"], "small");
        EXPECT_EQ(json["resolution"], r.resolution);
        EXPECT_EQ(json["engine"], r.engine);
        EXPECT_EQ(json["threads"], r.threads);
        EXPECT_EQ(json["policy"], r.policy);
        EXPECT_EQ(json["scans"], 3);
        EXPECT_EQ(json["rays"], 900);
        EXPECT_EQ(json["ms_per_scan"], meanOf(r.wallMs));
        EXPECT_EQ(json["median_ms"], medianOf(r.wallMs));
        EXPECT_EQ(json["cpu_ms_per_scan"], meanOf(r.cpuMs));
        EXPECT_EQ(json["ratio_to_octomap"], *r.ratioToOctomap);
        EXPECT_EQ(json["ratio_clock"], r.threads == 1 ? "cpu" : "wall");
        EXPECT_EQ(json["map_bytes"], r.mapBytes);
        EXPECT_TRUE(json["peak_bytes"].is_null());
        if (r.exact || r.engine == "octomap")
            EXPECT_EQ(json["digest"].get<std::string>().size(), 32u);
        else
            EXPECT_TRUE(json["digest"].is_null());
        if (r.engine != "grid" && r.engine != "octree-culling") continue;
        EXPECT_GT(json["traversed_cells"], 900);
        EXPECT_GT(json["super_rays"], 0);
        double sum = 0;
        for (const char* stage :
             {"to_rays", "super_rays", "culling", "traversal", "apply", "other"})
            sum += json["stage_seconds"][stage].get<double>();
        EXPECT_NEAR(sum, 3e-3 * meanOf(r.wallMs), 1e-9);
    }
    const std::string text = runsAsText(runs);
    EXPECT_NE(text.find("octree-culling"), std::string::npos) << text;
}

/// An engine that says it is exact and leaves out a scan's last point.
class Forgetful final : public BenchEngine {
 public:
    explicit Forgetful(const BenchEngineOptions& options)
        : right_(benchEngine("grid").make(options)) {}
    void prepare(const PointScan& scan) override {
        scan_ = scan;
        scan_.points.pop_back();
        right_->prepare(scan_);
    }
    void insert() override { right_->insert(); }
    std::size_t mapBytes() const override { return right_->mapBytes(); }
    std::string digest() const override { return right_->digest(); }
    std::optional<double> occupancy(const Eigen::Vector3f& p) const override {
        return right_->occupancy(p);
    }

 private:
    std::unique_ptr<BenchEngine> right_;
    PointScan scan_;
};

TEST(Compare, noticesMapsThatDiffer) {
    addBenchEngine(
        {"forgetful", "for this test", true, "", false,
         [](const BenchEngineOptions& o) { return std::make_unique<Forgetful>(o); }});
    TempFolder folder;
    auto request = smallRequest(folder);
    request.engines = {"octomap", "octree", "forgetful", "grid-full"};
    request.resolutions = {0.2};
    const auto runs = run(request);
    ASSERT_EQ(runs.size(), 6u);
    const auto conflicts = digestConflicts(runs);
    ASSERT_EQ(conflicts.size(), 1u);
    for (const char* part : {"small", "0.2", "netEvidence", "forgetful", "octree", "grid-full"})
        EXPECT_NE(conflicts[0].find(part), std::string::npos) << conflicts[0];
    EXPECT_EQ(conflicts[0].find("octomap"), std::string::npos) << conflicts[0];

    // What is not the same data, resolution and policy may differ.
    std::vector<BenchRun> others;
    for (const BenchRun& r : runs)
        if (r.engine == "forgetful" || (r.engine == "octree" && r.threads == 1))
            others.push_back(r);
    ASSERT_EQ(others.size(), 2u);
    EXPECT_EQ(digestConflicts(others).size(), 1u);
    others[0].resolution = 0.3;
    EXPECT_TRUE(digestConflicts(others).empty());
}

TEST(Compare, policiesTakeTurnsInOneRun) {
    TempFolder folder;
    auto request = smallRequest(folder);
    request.resolutions = {0.2};
    request.threads = {1};
    request.engines = {"octomap", "grid", "octree"};
    request.policies = {UpdatePolicy::netEvidence, UpdatePolicy::everyRay};
    const auto runs = run(request);
    std::vector<std::string> found;
    for (const auto& r : runs) found.push_back(r.engine + " " + r.policy);
    EXPECT_EQ(found, (std::vector<std::string>{"octomap oncePerScan", "grid netEvidence",
                                               "grid everyRay", "octree netEvidence",
                                               "octree everyRay"}));
    EXPECT_EQ(runs[1].digest, runs[3].digest);
    EXPECT_EQ(runs[2].digest, runs[4].digest);
    EXPECT_NE(runs[1].digest, runs[2].digest);
    EXPECT_TRUE(digestConflicts(runs).empty());

    request.unnecessary = true;
    EXPECT_THROW(request.validate(), InputError);
    request.unnecessary = false;
    request.policies = {UpdatePolicy::everyRay, UpdatePolicy::everyRay};
    EXPECT_THROW(request.validate(), InputError);
}

TEST(Compare, unnecessaryTraversalsAreThoseOfSaturatedCells) {
    TempFolder folder;
    auto request = smallRequest(folder);
    request.unnecessary = true;
    request.policies = {UpdatePolicy::everyRay};
    request.resolutions = {0.5};
    request.threads = {1};
    request.engines = {"grid-perRay", "grid-culling", "octree-superRays"};
    // Coarse cells and few points: the counting itself, by hand.
    const PointScans scans = loadPointScans({request.data[0], {}, 1});
    std::uint64_t expected = 0;
    BenchEngineOptions options;
    options.resolution = 0.5;
    options.policy = UpdatePolicy::everyRay;
    const auto engine = benchEngine("grid-reference").make(options);
    const CellGeometry<3> geometry(0.5);
    for (const PointScan& scan : scans.scans) {
        for (const Eigen::Vector3f& p : scan.points)
            forEachFreeCell(RayLine<3>(geometry, scan.origin.cast<double>(), p.cast<double>()),
                            [&](const Cell<3>& c) {
                                const auto value =
                                    engine->occupancy(geometry.center(c).cast<float>());
                                expected += value && *value < 0.11921;
                            });
        engine->prepare(scan);
        engine->insert();
    }
    EXPECT_GT(expected, 100u);
    const auto runs = run(request);
    ASSERT_EQ(runs.size(), 3u);
    EXPECT_EQ(runs[0].unnecessaryCells, expected);
    ASSERT_TRUE(runs[1].unnecessaryCells && runs[2].unnecessaryCells);
    EXPECT_LT(*runs[1].unnecessaryCells, expected);
    EXPECT_LE(*runs[2].unnecessaryCells, expected);
}

TEST(Compare, refusesBadRequestsBeforeWork) {
    TempFolder folder;
    const auto message = [&](const auto& change) {
        auto request = smallRequest(folder);
        change(request);
        return messageOf<std::exception>([&] { run(request); });
    };
    const auto has = [](const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    };
    EXPECT_TRUE(has(message([](auto& r) { r.data.clear(); }), "no data"));
    EXPECT_TRUE(has(message([](auto& r) { r.engines = {"gird"}; }), "'gird'"));
    EXPECT_TRUE(has(message([](auto& r) { r.engines = {"grid", "grid"}; }), "twice"));
    EXPECT_TRUE(has(message([](auto& r) { r.resolutions = {0}; }), "resolution"));
    EXPECT_TRUE(has(message([](auto& r) { r.threads = {0}; }), "threads"));
    EXPECT_TRUE(has(message([](auto& r) { r.superRayThreshold = 0; }), "superRayThreshold"));
    EXPECT_TRUE(has(message([](auto& r) { r.source.maxScans = 0; }), "at least 1"));
    EXPECT_TRUE(has(message([](auto& r) { r.data = {"absent.rawlog"}; }), "absent.rawlog"));
}

TEST(Statistics, meanAndMedian) {
    EXPECT_EQ(meanOf({}), 0);
    EXPECT_EQ(medianOf({}), 0);
    EXPECT_EQ(meanOf({1, 2, 6}), 3);
    EXPECT_EQ(medianOf({6, 1, 2}), 2);
    EXPECT_EQ(medianOf({4, 1, 2, 9}), 3);
}

}  // namespace
}  // namespace superray
