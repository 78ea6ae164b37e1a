// SPDX-License-Identifier: BSD-3-Clause
// The formats other than rawlogs: simplemaps, OctoMap scan graphs, KITTI folders.

#include <gtest/gtest.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/poses/CPose3DPDFParticles.h>
#include <mrpt/poses/CPose3DPDFSOG.h>
#include <octomap/ScanGraph.h>
#include <superray/eval/input_error.h>
#include <superray/eval/scan_source.h>

#include <cmath>
#include <cstring>

#include "eval/recorded_scans.h"
#include "eval/sources/pose_matchers.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;
using mrpt::poses::CPose3D;

std::vector<Scan> readAll(const std::string& path, const ScanSourceOptions& options = {}) {
    const auto source = openScanSource(path, options);
    std::vector<Scan> scans;
    while (auto scan = source->next()) scans.push_back(*scan);
    EXPECT_EQ(scans.size(), source->total());
    return scans;
}

std::string errorOf(const std::string& path, const ScanSourceOptions& options = {}) {
    return messageOf<InputError>([&] { openScanSource(path, options); });
}

void expectError(const std::string& path, const std::string& part,
                 const ScanSourceOptions& options = {}) {
    const auto message = errorOf(path, options);
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

/// Every prefix of a file is refused, or accepted with a warning if asked for.
void expectTruncationIsSeen(const TempFolder& folder, const std::string& name) {
    const auto whole = readWholeFile(folder / name);
    int cases = 0;
    for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 50) {
        const auto path = folder.write("cut-" + name, whole.substr(0, length));
        EXPECT_NE(errorOf(path), "no exception") << length << " bytes of " << whole.size();
        ++cases;
    }
    EXPECT_GE(cases, 49);
}

TEST(SimpleMapSource, givesPosesAndObservationsOfTheKeyframes) {
    TempFolder folder;
    mrpt::maps::CSimpleMap map;
    std::vector<CPose3D> poses;
    for (unsigned i = 0; i < 4; ++i) {
        poses.emplace_back(i, 2.0 * i, 0.5, 0.3 * i, 0.1, -0.1);
        const auto frame = mrpt::obs::CSensoryFrame::Create();
        frame->insert(makeCloud(10.0 + i, i, i % 2 == 0 ? "EVEN" : "ODD"));
        frame->insert(makeOdometry(10.0 + i, {}));
        const auto pose = mrpt::poses::CPose3DPDFGaussian::Create(poses.back());
        map.insert(pose, frame);
    }
    for (const char* name : {"a.simplemap", "a.simplemap.gz"}) {
        ASSERT_TRUE(map.saveToFile(folder / name));
        const auto scans = readAll(folder / name);
        ASSERT_EQ(scans.size(), 4u);
        for (unsigned i = 0; i < 4; ++i) {
            expectPoseNear(scans[i].T_map_robot, poses[i], 0);
            EXPECT_EQ(scans[i].timestamp, at(10.0 + i));
            EXPECT_EQ(pointsOf(*scans[i].observation), pointsOf(*makeCloud(10.0 + i, i)));
        }
    }
    ScanSourceOptions options;
    options.sensorLabel = "ODD";
    EXPECT_EQ(readAll(folder / "a.simplemap", options).size(), 2u);
    options.maxScans = 1;
    EXPECT_EQ(readAll(folder / "a.simplemap", options).size(), 1u);
    options.sensorLabel = "NONE";
    expectError(folder / "a.simplemap", "'NONE'", options);
    options = {};
    options.poses = PoseOrigin::file;
    options.posesFile = folder.write("a.tum", "12 7 8 9 0 0 0 1\n");
    const auto posed = readAll(folder / "a.simplemap", options);
    ASSERT_EQ(posed.size(), 1u);
    expectPoseNear(posed[0].T_map_robot, CPose3D(7, 8, 9, 0, 0, 0), 0);
    expectTruncationIsSeen(folder, "a.simplemap");
    expectError(folder.write("b.simplemap", "not a map"), "is not a whole simplemap");
    expectError(folder / "absent.simplemap", "no such file");
}

TEST(SimpleMapSource, leavesOutKeyframesWithoutAPose) {
    TempFolder folder;
    mrpt::maps::CSimpleMap map;
    const auto insert = [&](const mrpt::poses::CPose3DPDF::Ptr& pose) {
        auto frame = mrpt::obs::CSensoryFrame::Create();
        frame->insert(makeCloud(10.0 + static_cast<double>(map.size()), 1));
        map.insert(pose, frame);
    };
    insert(mrpt::poses::CPose3DPDFGaussian::Create(CPose3D(1, 2, 3, 0, 0, 0)));
    insert(mrpt::poses::CPose3DPDFParticles::Create(0));
    insert(mrpt::poses::CPose3DPDFSOG::Create(0));
    insert(mrpt::poses::CPose3DPDFGaussian::Create(CPose3D(std::nan(""), 0, 0, 0, 0, 0)));
    ASSERT_TRUE(map.saveToFile(folder / "a.simplemap"));
    const auto source = openScanSource(folder / "a.simplemap");
    EXPECT_EQ(source->total(), 1u);
    EXPECT_EQ(source->skipped().badPoses, 3u);
    EXPECT_EQ(source->skipped().withoutPose, 3u);
    expectPoseNear(source->next()->T_map_robot, CPose3D(1, 2, 3, 0, 0, 0), 0);
}

TEST(ScanGraphSource, agreesWithOctomap) {
    TempFolder folder;
    octomap::ScanGraph graph;
    for (int i = 0; i < 3; ++i) {
        auto* points = new octomap::Pointcloud();
        for (int k = 0; k < 10 * i + 1; ++k)
            points->push_back(0.1f * static_cast<float>(k), -0.3f,
                              2.5f * static_cast<float>(i));
        graph.addNode(
            points, octomap::pose6d(1.0f, 2.0f * static_cast<float>(i), 3, 0.1, 0.2, 0.4 * i));
    }
    ASSERT_TRUE(graph.writeBinary(folder / "a.graph"));
    const auto scans = readAll(folder / "a.graph");
    ASSERT_EQ(scans.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
        const auto& node = *graph.getNodeByID(static_cast<unsigned>(i));
        const auto points = pointsOf(*scans[i].observation);
        ASSERT_EQ(points.size(), 3 * node.scan->size());
        for (std::size_t k = 0; k < node.scan->size(); ++k) {
            for (unsigned axis = 0; axis < 3; ++axis)
                EXPECT_EQ(points[3 * k + axis], (*node.scan)[k](axis));
            double x, y, z;
            scans[i].T_map_robot.composePoint(points[3 * k], points[3 * k + 1],
                                              points[3 * k + 2], x, y, z);
            const auto expected = node.pose.transform((*node.scan)[k]);
            EXPECT_NEAR(x, static_cast<double>(expected.x()), 1e-5);
            EXPECT_NEAR(y, static_cast<double>(expected.y()), 1e-5);
            EXPECT_NEAR(z, static_cast<double>(expected.z()), 1e-5);
        }
    }
    expectTruncationIsSeen(folder, "a.graph");
}

TEST(ScanGraphSource, refusesWhatIsLeftOver) {
    TempFolder folder;
    octomap::ScanGraph graph;
    for (int i = 0; i < 3; ++i) {
        auto* points = new octomap::Pointcloud();
        for (int k = 0; k < 20; ++k) points->push_back(1, 2, static_cast<float>(i));
        graph.addNode(points, octomap::pose6d());
    }
    graph.connectPrevious();
    ASSERT_TRUE(graph.writeBinary(folder / "one.graph"));
    graph.addEdge(0, 2);
    ASSERT_TRUE(graph.writeBinary(folder / "two.graph"));
    for (const char* name : {"one.graph", "two.graph"}) {
        EXPECT_EQ(readAll(folder / name).size(), 3u) << name;
        const auto whole = readWholeFile(folder / name);
        expectError(folder.write("more.graph", whole + std::string(700, 'x')),
                    "bytes are left after its 3 nodes");
        expectError(folder.write("cut.graph", whole.substr(0, whole.size() - 30)),
                    "bytes are left after its 3 nodes");
        std::string fewer = whole;
        fewer[0] = 2;
        expectError(folder.write("fewer.graph", fewer), "bytes are left after its 2 nodes");
    }
}

TEST(ScanGraphSource, refusesCoordinatesOfACountry) {
    TempFolder folder;
    octomap::ScanGraph graph;
    auto* points = new octomap::Pointcloud();
    points->push_back(1, 2, -40000);
    graph.addNode(points, octomap::pose6d());
    ASSERT_TRUE(graph.writeBinary(folder / "far.graph"));
    const auto error = messageOf<InputError>([&] { readAll(folder / "far.graph"); });
    EXPECT_NE(error.find("far.graph: has points at z -40000 m"), std::string::npos) << error;
}

TEST(ScanGraphSource, refusesWhatItCannotUse) {
    TempFolder folder;
    expectError(folder.write("empty.graph", std::string(4, '\0')), "holds no scans");
    // One node that claims 2^32 - 1 points.
    expectError(folder.write("huge.graph", std::string("\1\0\0\0\xff\xff\xff\xff", 8)),
                "more than the file has room for");
    ScanSourceOptions options;
    options.poses = PoseOrigin::file;
    options.posesFile = folder.write("a.tum", "1 0 0 0 0 0 0 1\n");
    expectError(folder.write("a.graph", std::string(4, '\0')), "no times", options);
    std::mt19937 random(3);
    for (int i = 0; i < 200; ++i) {
        std::string noise(random() % 500, ' ');
        for (char& c : noise) c = static_cast<char>(random());
        EXPECT_NE(errorOf(folder.write("noise.graph", noise)), "no exception");
    }
}

TEST(ScanGraphSource, acceptsTheWholeNodesOfATruncatedFileIfAsked) {
    TempFolder folder;
    octomap::ScanGraph graph;
    for (int i = 0; i < 3; ++i) {
        auto* points = new octomap::Pointcloud();
        points->push_back(1, 2, static_cast<float>(i));
        graph.addNode(points, octomap::pose6d());
    }
    ASSERT_TRUE(graph.writeBinary(folder / "a.graph"));
    const auto whole = readWholeFile(folder / "a.graph");
    constexpr std::size_t kNodeBytes = 4 + 28 + 64 + 4;
    const auto path = folder.write("cut.graph", whole.substr(0, 4 + 2 * kNodeBytes + 10));
    expectError(path, "scans before it: 2");
    ScanSourceOptions options;
    options.truncation = Truncation::accept;
    const auto scans = readAll(path, options);
    ASSERT_EQ(scans.size(), 2u);
    EXPECT_EQ(pointsOf(*scans[1].observation), (std::vector<float>{1, 2, 1}));
}

std::string bytesOf(const std::vector<float>& values) {
    std::string bytes(values.size() * sizeof(float), '\0');
    std::memcpy(bytes.data(), values.data(), bytes.size());
    return bytes;
}

constexpr char kIdentity[] = "1 0 0 0 0 1 0 0 0 0 1 0\n";
/// KITTI's axes: Velodyne x forward, y left, z up; camera z forward, x right,
/// y down. The Velodyne here is 0.5 m behind and 0.1 m above the camera.
constexpr char kCalibration[] =
    "P0: 1 0 0 0 0 1 0 0 0 0 1 0\nTr: 0 -1 0 0 0 0 -1 -0.1 1 0 0 -0.5\n";

TEST(KittiSource, turnsCameraPosesIntoVelodynePosesWithZUp) {
    TempFolder folder;
    folder.write("seq/velodyne/000000.bin", bytesOf({1, 2, 3, 0.5f, 4, 5, 6, 0.5f}));
    folder.write("seq/velodyne/000001.bin", bytesOf({7, 8, 9, 0.1f}));
    folder.write("seq/calib.txt", kCalibration);
    // Second camera: 2 m forward, 0.3 m to the right, 0.4 m up, turned left by
    // 90 degrees (about the camera's y, which points down).
    folder.write("seq/poses.txt", std::string(kIdentity) + "0 0 -1 0.3 0 1 0 -0.4 1 0 0 2\n");
    folder.write("seq/times.txt", "0\n0.25\n");
    const auto scans = readAll(folder / "seq");
    ASSERT_EQ(scans.size(), 2u);
    EXPECT_EQ(pointsOf(*scans[0].observation), (std::vector<float>{1, 2, 3, 4, 5, 6}));
    EXPECT_EQ(pointsOf(*scans[1].observation), (std::vector<float>{7, 8, 9}));
    EXPECT_EQ(scans[1].timestamp, at(0.25));
    expectPoseNear(scans[0].T_map_robot, CPose3D(-0.5, 0, 0.1, 0, 0, 0));
    // The camera stands at (2, -0.3, 0.4), the Velodyne 0.5 m behind it: y - 0.5.
    expectPoseNear(scans[1].T_map_robot, CPose3D(2, -0.8, 0.5, M_PI / 2, 0, 0));
}

TEST(KittiSource, findsPosesWhereTheBenchmarkPutsThem) {
    TempFolder folder;
    folder.write("sequences/07/velodyne/000002.bin", bytesOf({1, 2, 3, 0}));
    folder.write("sequences/07/calib.txt", kCalibration);
    expectError(folder / "sequences/07", "has no poses");
    folder.write("poses/07.txt", std::string(kIdentity) + kIdentity);
    expectError(folder / "sequences/07", "has 2 poses for 3 frames");
    folder.write("poses/07.txt",
                 std::string(kIdentity) + kIdentity + "1 0 0 0 0 1 0 0 0 0 1 9\n");
    const auto scans = readAll(folder / "sequences/07");
    ASSERT_EQ(scans.size(), 1u);
    expectPoseNear(scans[0].T_map_robot, CPose3D(8.5, 0, 0.1, 0, 0, 0));
    EXPECT_EQ(scans[0].timestamp, at(0.2));
}

TEST(KittiSource, takesPosesFromAFile) {
    TempFolder folder;
    folder.write("seq/velodyne/000000.bin", bytesOf({1, 2, 3, 0}));
    folder.write("seq/velodyne/000001.bin", bytesOf({1, 2, 3, 0}));
    ScanSourceOptions options;
    options.poses = PoseOrigin::file;
    options.posesFile = folder.write("a.tum", "0.1 1 2 3 0 0 0 1\n");
    const auto scans = readAll(folder / "seq", options);
    ASSERT_EQ(scans.size(), 1u);
    expectPoseNear(scans[0].T_map_robot, CPose3D(1, 2, 3, 0, 0, 0));
}

TEST(KittiSource, saysWhatIsWrong) {
    TempFolder folder;
    expectError(folder.write("seq/readme", "").substr(0, (folder / "seq").size()),
                "has no velodyne/*.bin");
    folder.write("seq/velodyne/000000.bin", bytesOf({1, 2, 3, 0}));
    expectError(folder / "seq", "calib.txt: no such file");
    folder.write("seq/calib.txt", "P0: 1 2 3\n");
    expectError(folder / "seq", "has no row 'Tr:'");
    folder.write("seq/calib.txt", "Tr: 1 0 0\n");
    expectError(folder / "seq", "calib.txt:1: has 3 numbers");
    folder.write("seq/calib.txt", "Tr: 2 0 0 0 0 1 0 0 0 0 1 0\n");
    expectError(folder / "seq", "not a rotation");
    folder.write("seq/calib.txt", kCalibration);
    folder.write("seq/poses.txt", "1 0 0 0 0 1 0 0 0 0 1 nan\n");
    expectError(folder / "seq", "poses.txt:1: every column must be a finite number");
    folder.write("seq/poses.txt", kIdentity);
    folder.write("seq/velodyne/000000.bin", "12345");
    EXPECT_NE(messageOf<InputError>([&] { readAll(folder / "seq"); }).find("is truncated"),
              std::string::npos);
    folder.write("seq/velodyne/first.bin", "");
    expectError(folder / "seq", "is not named by its frame number");
}

}  // namespace
}  // namespace superray
