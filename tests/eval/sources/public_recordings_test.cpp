// SPDX-License-Identifier: BSD-3-Clause
// The recordings that MRPT and OctoMap install: what becomes of each, with the digest of its
// map by OctoMap's rule at 0.2 m.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>
#include <superray/eval/map_build.h>
#include <superray/eval/map_request.h>
#include <superray/eval/recording_info.h>
#include <superray/maps/map_factory.h>
#include <superray/maps/mrpt_compat.h>

#include <filesystem>
#include <limits>
#include <set>
#include <vector>

#include "eval/temp_folder.h"

namespace superray {
namespace {

const std::string kMrpt = "/usr/share/mrpt/datasets/";
const std::string kOctomap = "/usr/share/doc/liboctomap-dev/examples/data/";

struct Recording {
    const char *name, *poses, *digest;
    PoseOrigin origin;
    std::uint64_t scans;
};

void PrintTo(const Recording& r, std::ostream* out) {
    *out << r.name;
}

/// What a file of the lists is called in messages of tests.
std::string absent(const std::string& path) {
    return "RECORDING ABSENT: " + path + "; NOT TESTED";
}

/// Recordings that hold nothing that a map could be made of.
const std::vector<std::string>& withoutScans() {
    static const std::vector<std::string> names = {
        "RO-SLAM_demo.rawlog",           "kf-slam_6D_demo.rawlog",
        "kf-slam_6D_demo_DA.rawlog",     "kf-slam_6D_demo_noncentered.rawlog",
        "kf-slam_demo.rawlog",           "test_rtk_path.rawlog",
        "graph_2d_circle_50nodes.graph", "graph_2d_circle_50nodes_groundtruth.graph"};
    return names;
}
const std::string kWithoutAngles = "rot_scan_velodyne.rawlog";

class PublicRecordings : public testing::TestWithParam<Recording> {};

TEST_P(PublicRecordings, mapWithoutASurprise) {
    const Recording& r = GetParam();
    const std::string path = kMrpt + r.name;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << absent(path);
    if (std::string(r.name) == "rot_scan_2d.rawlog" && !kReadsEarlierRotatingScans)
        GTEST_SKIP() << "this MRPT cannot read its own " << path << "; NOT TESTED";
    ScanSourceOptions options;
    options.poses = r.origin;
    ScanSources sources;
    sources.push_back(openScanSource(path, options));
    MapRequest request;
    request.policy = "oncePerScan";
    request.resolution = 0.2;
    const auto map = makeMap(request);
    const auto report = buildMap(sources, *map, std::numeric_limits<std::uint64_t>::max(),
                                 [](const BuildProgress&) {});
    EXPECT_EQ(report.scans, r.scans);
    EXPECT_EQ(report.unusable, 0u);
    EXPECT_EQ(report.poses.front().substr(0, std::string(r.poses).size()), r.poses);
    EXPECT_TRUE(report.warnings.empty());
    EXPECT_EQ(dynamic_cast<const SuperRayMapInterface&>(*map).digest(), r.digest);
    const auto info = inspectRecording(path, options);
    EXPECT_TRUE(info.canBuild) << info.problem;
    EXPECT_EQ(info.scans, r.scans);
}

const std::vector<Recording>& withScans() {
    static const std::vector<Recording> recordings = {
        Recording{"2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog", "actions, 224",
                  "8a4ef3be1e6322f163fe9e11ce469f87", PoseOrigin::input, 225},
        Recording{"localization_demo.rawlog", "actions, 37", "9150d8a6d115e3e30718fc78a8b4f3a6",
                  PoseOrigin::input, 37},
        Recording{"rot_scan_2d.rawlog", "the robot stays", "8bf5dc2e7e978475ec532dfa7cd43046",
                  PoseOrigin::fixed, 1},
        Recording{"test_velodyne_VLP16.rawlog", "the robot stays",
                  "10343ded15566f0e21c5acf03bf5d61c", PoseOrigin::fixed, 1},
        Recording{"tests_rgbd.rawlog", "the robot stays", "cf9464b6871e17936f6daa45d2afeef4",
                  PoseOrigin::fixed, 1},
        Recording{"graphslam-engine-demos/action_observations_map/"
                  "range_030_bearing_015.rawlog",
                  "actions, 1460", "d22e9c29fa454282125101795120b976", PoseOrigin::input, 1460},
        Recording{"graphslam-engine-demos/action_observations_map/simul.rawlog",
                  "actions, 1733", "9d57a1b7d2cf91a9c563a398f4cc2895", PoseOrigin::input, 1733},
        Recording{"uwb_ro-localization_demo.rawlog", "actions, 343",
                  "4c2d088de255ac1576a08c94e184c083", PoseOrigin::input, 343},
        Recording{"localization_demo.simplemap.gz", "key frames, 72",
                  "ceeee9346d2ab62db530de6fd3e13711", PoseOrigin::input, 72},
        Recording{"malaga-cs-fac-building.simplemap.gz", "key frames, 99",
                  "685b1a3a89a4e57088b8163a04fd1fe1", PoseOrigin::input, 99}};
    return recordings;
}

INSTANTIATE_TEST_SUITE_P(Mrpt, PublicRecordings, testing::ValuesIn(withScans()));

TEST(OtherPublicRecordings, withoutScansAreRefusedWithTheReason) {
    for (const std::string& name : withoutScans()) {
        if (!std::filesystem::exists(kMrpt + name)) GTEST_SKIP() << absent(kMrpt + name);
        std::string problem;
        try {
            const auto info = inspectRecording(kMrpt + name);
            EXPECT_FALSE(info.canBuild) << name;
            problem = info.problem;
        } catch (const InputError& e) {
            problem = e.what();
        }
        const bool isOfPoses = name.rfind("graph_", 0) == 0;
        EXPECT_NE(problem.find(isOfPoses ? "is a graph of poses (text)" : "holds no scans"),
                  std::string::npos)
            << problem;
    }
}

TEST(OtherPublicRecordings, rowsWithoutAnglesAreRefusedWithTheReason) {
    const std::string path = kMrpt + kWithoutAngles;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << absent(path);
    if (!kReadsEarlierRotatingScans)
        GTEST_SKIP() << "this MRPT cannot read its own " << path << "; NOT TESTED";
    const auto info = inspectRecording(path);
    ASSERT_EQ(info.sensors.size(), 1u);
    EXPECT_NE(info.sensors.front().unreadable.find("16 rows"), std::string::npos);
    ScanSourceOptions fixed;
    fixed.poses = PoseOrigin::fixed;
    ScanSources sources;
    sources.push_back(openScanSource(path, fixed));
    const auto map = makeMap({});
    EXPECT_THROW(buildMap(sources, *map, std::numeric_limits<std::uint64_t>::max(),
                          [](const BuildProgress&) {}),
                 InputError);
}

TEST(OtherPublicRecordings, ofMrptAreAllInTheseLists) {
    if (!std::filesystem::exists(kMrpt)) GTEST_SKIP() << absent(kMrpt);
    std::set<std::string> known(withoutScans().begin(), withoutScans().end());
    known.insert(kWithoutAngles);
    for (const Recording& r : withScans()) known.insert(r.name);
    std::size_t found = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(kMrpt)) {
        const std::string name =
            std::filesystem::relative(entry.path(), kMrpt).generic_string();
        const auto ends = [&](const std::string& end) {
            return name.size() > end.size() &&
                   name.compare(name.size() - end.size(), end.size(), end) == 0;
        };
        if (!ends(".rawlog") && !ends(".simplemap.gz") && !ends(".graph")) continue;
        EXPECT_EQ(known.count(name), 1u) << name;
        ++found;
    }
    EXPECT_EQ(found, known.size());
}

TEST(OtherPublicRecordings, ofOctomapAreMapsAndScans) {
    if (!std::filesystem::exists(kOctomap + "geb079.bt"))
        GTEST_SKIP() << "RECORDING ABSENT: " << kOctomap << "geb079.bt; NOT TESTED";
    const auto map = loadMap(kOctomap + "geb079.bt");
    EXPECT_GT(dynamic_cast<const SuperRayMapInterface&>(*map).cellTotals().occupied, 100000u);
    MapRequest request;
    request.policy = "oncePerScan";
    request.resolution = 0.2;
    const auto sphere = makeMap(request);
    ScanSources sources;
    sources.push_back(openScanSource(kOctomap + "spherical_scan.graph"));
    const auto report = buildMap(sources, *sphere, std::numeric_limits<std::uint64_t>::max(),
                                 [](const BuildProgress&) {});
    EXPECT_EQ(report.scans, 1u);
    EXPECT_EQ(dynamic_cast<const SuperRayMapInterface&>(*sphere).digest(),
              "eb5a4eda44846baa16de3f76361ac762");
}

}  // namespace
}  // namespace superray
