// SPDX-License-Identifier: BSD-3-Clause
// Recordings of every format, written by other programs (tests/data/formats), against the
// same scans in a rawlog; and what is told of inputs that are none.

#include <gtest/gtest.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <superray/eval/input_error.h>
#include <superray/eval/map_build.h>
#include <superray/maps/CSuperRayGridMap3D.h>

#include <filesystem>
#include <optional>
#include <random>

#include "eval/recorded_scans.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

namespace fs = std::filesystem;
using namespace test;
using mrpt::poses::CPose3D;

std::string sample(const std::string& name) {
    return std::string(SUPERRAY_TEST_DATA_DIR) + "/formats/" + name;
}

/// As make_samples.py.
mrpt::obs::CObservationPointCloud::Ptr sampleScan(int scan) {
    auto cloud = mrpt::obs::CObservationPointCloud::Create();
    cloud->timestamp = at(1000 + 0.5 * scan);
    auto points = mrpt::maps::CSimplePointsMap::Create();
    for (int i = 0; i < 60; ++i)
        points->insertPoint(static_cast<float>((i * 37 + scan * 11) % 200 - 100) / 16.0f,
                            static_cast<float>((i * 53 + scan * 7) % 160 - 80) / 16.0f,
                            static_cast<float>((i * 29) % 40 - 20) / 16.0f);
    cloud->pointcloud = points;
    return cloud;
}

CPose3D samplePose(int scan) {
    return CPose3D(0.013 + 0.5 * scan, 0.027 - 0.25 * scan, 0.041 + 0.125 * scan, 0, 0, 0);
}

mrpt::obs::CObservation3DRangeScan::Ptr sampleImage(int scan) {
    auto image = mrpt::obs::CObservation3DRangeScan::Create();
    image->timestamp = at(1000 + 0.5 * scan);
    image->hasRangeImage = true;
    image->range_is_depth = true;
    image->rangeUnits = 1.0f / 5000;
    image->maxRange = 100;
    image->cameraParams.ncols = 32;
    image->cameraParams.nrows = 24;
    image->cameraParams.setIntrinsicParamsFromValues(30, 31, 15.4, 11.6);
    // The ground truth is that of the optical frame.
    image->sensorPose = -CPose3D(0, 0, 0, -M_PI / 2, 0, -M_PI / 2);
    image->rangeImage.setSize(24, 32);
    for (int r = 0; r < 24; ++r)
        for (int c = 0; c < 32; ++c)
            image->rangeImage(r, c) =
                (r + c) % 7 == 0
                    ? std::uint16_t{0}
                    : static_cast<std::uint16_t>(5000 + 100 * r + 50 * c + 700 * scan);
    return image;
}

struct Built {
    std::string digest, poses;
    std::uint64_t scans = 0;
};

Built build(const std::string& path, const ScanSourceOptions& options = {}) {
    ScanSources sources;
    sources.push_back(openScanSource(path, options));
    CSuperRayGridMap3D map(0.3);
    const auto report = buildMap(sources, map, std::numeric_limits<std::uint64_t>::max(),
                                 [](const BuildProgress&) {});
    return {map.digest(), report.poses.front(), report.scans};
}

/// The map of the samples, given as a rawlog.
std::string expectedDigest(bool images = false) {
    TempFolder folder;
    Objects objects;
    for (int i = 0; i < 3; ++i) {
        objects.push_back(makePose(1000 + 0.5 * i, samplePose(i)));
        if (images)
            objects.push_back(sampleImage(i));
        else
            objects.push_back(sampleScan(i));
    }
    return build(writeRawlog(folder / "a.rawlog", objects)).digest;
}

ScanSourceOptions withPoses(const std::string& file) {
    ScanSourceOptions options;
    options.poses = PoseOrigin::file;
    options.posesFile = file;
    return options;
}

ScanSourceOptions sampleCamera() {
    ScanSourceOptions options;
    options.depthCamera.fx = 30;
    options.depthCamera.fy = 31;
    options.depthCamera.cx = 15.4;
    options.depthCamera.cy = 11.6;
    return options;
}

std::string errorOf(const std::string& path, const ScanSourceOptions& options = {}) {
    return messageOf<InputError>([&] { build(path, options); });
}

void expectPart(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text << " must have: " << part;
}

TEST(Formats, pointCloudFilesGiveTheMapOfTheRawlog) {
    const auto expected = expectedDigest();
    for (const char* name :
         {"pcd_ascii", "pcd_binary", "pcd_compressed", "ply_ascii", "ply_binary"})
        for (const char* poses : {"poses.tum", "poses.kitti"}) {
            const auto built = build(sample(name), withPoses(sample(poses)));
            EXPECT_EQ(built.digest, expected) << name << " " << poses;
            EXPECT_EQ(built.scans, 3u);
        }
    expectPart(build(sample("pcd_ascii"), withPoses(sample("poses.tum"))).poses,
               "3, 0.0 to 1.0 s");
    expectPart(build(sample("pcd_ascii"), withPoses(sample("poses.kitti"))).poses,
               "paired with the scans by their order");
    expectPart(errorOf(sample("pcd_ascii")), "give a poses file (--poses FILE)");
}

TEST(Formats, oneCloudIsARecordingAndViewpointsArePoses) {
    TempFolder folder;
    ScanSourceOptions fixed;
    fixed.poses = PoseOrigin::fixed;
    const auto one = build(sample("pcd_binary/1000.500000.pcd"), fixed);
    EXPECT_EQ(one.scans, 1u);
    EXPECT_EQ(build(sample("ply_binary/1000.500000.ply"), fixed).digest, one.digest);
    // In capitals, with a viewpoint.
    auto text = readWholeFile(sample("pcd_ascii/1000.500000.pcd"));
    const std::string from = "VIEWPOINT 0 0 0 1 0 0 0";
    text.replace(text.find(from), from.size(), "VIEWPOINT 0.513 -0.223 0.166 1 0 0 0");
    const auto viewed = build(folder.write("A.PCD", text));
    const auto posed =
        build(sample("pcd_ascii/1000.500000.pcd"), withPoses(sample("poses.tum")));
    EXPECT_EQ(viewed.digest, posed.digest);
    EXPECT_EQ(viewed.poses, "viewpoints of the files, 1");
}

TEST(Formats, kittiFoldersGiveTheMapOfTheRawlog) {
    const auto expected = expectedDigest();
    const auto sequence = sample("kitti/sequences/07");
    EXPECT_EQ(build(sequence).digest, expected);
    EXPECT_EQ(build(sequence, withPoses(sample("kitti/poses/07.txt"))).digest, expected);
    EXPECT_EQ(build(sequence, withPoses(sample("poses.tum"))).digest, expected);
    EXPECT_EQ(build(sample("kitti_raw/2011_09_26_drive_0001_sync")).digest, expected);
    EXPECT_EQ(build(sample("mulran"), withPoses(sample("global_pose.csv"))).digest, expected);
}

TEST(Formats, sequencesBehindSymbolicLinksFindTheirPoses) {
    TempFolder folder;
    const auto expected = expectedDigest();
    // A link of another name to the sequence; and a link of its name, with poses beside it.
    fs::create_directory_symlink(sample("kitti/sequences/07"), folder / "drive");
    EXPECT_EQ(build(folder / "drive").digest, expected);
    EXPECT_EQ(build(folder / "drive/").digest, expected);
    fs::create_directory(folder / "disk");
    fs::copy(sample("kitti/sequences/07"), folder / "disk/abc", fs::copy_options::recursive);
    fs::create_directories(folder / "mine/sequences");
    fs::create_directory_symlink(folder / "disk/abc", folder / "mine/sequences/07");
    folder.write("mine/poses/07.txt", readWholeFile(sample("kitti/poses/07.txt")));
    EXPECT_EQ(build(folder / "mine/sequences/07").digest, expected);
    expectPart(errorOf(folder / "disk/abc"), "looked for");
}

TEST(Formats, rgbdFoldersGiveTheMapOfTheRawlog) {
    TempFolder folder;
    const auto expected = expectedDigest(true);
    EXPECT_EQ(build(sample("rgbd"), sampleCamera()).digest, expected);
    EXPECT_NE(build(sample("rgbd")).digest, expected) << "the camera must matter";
    // As ICL-NUIM: frames by number, pairs of files, another name of the truth.
    fs::create_directories(folder / "icl/depth");
    std::string pairs, truth;
    for (int i = 0; i < 3; ++i) {
        const std::string stamp = i == 0   ? "1000.000000"
                                  : i == 1 ? "1000.500000"
                                           : "1001.000000";
        const auto number = std::to_string(i);
        fs::copy(sample("rgbd/depth/" + stamp + ".png"),
                 folder / ("icl/depth/" + number + ".png"));
        pairs += number + " depth/" + number + ".png " + number + " rgb/" + number + ".png\n";
        char pose[200];
        std::snprintf(pose, sizeof pose, "%d %.3f %.3f %.3f 0 0 0 1\n", i, 0.013 + 0.5 * i,
                      0.027 - 0.25 * i, 0.041 + 0.125 * i);
        truth += pose;
    }
    folder.write("icl/associations.txt", pairs);
    folder.write("icl/livingRoom1.gt.freiburg", truth);
    EXPECT_EQ(build(folder / "icl", sampleCamera()).digest, expected);
    fs::remove(folder / "icl/livingRoom1.gt.freiburg");
    expectPart(errorOf(folder / "icl", sampleCamera()), "groundtruth.txt");
}

TEST(Formats, unknownInputsAreNamedWithTheWayOut) {
    TempFolder folder;
    struct Case {
        const char *name, *contents, *advice;
    };
    for (const Case& c : {Case{"a.bag", "#ROSBAG V2.0\n", "rosbag2rawlog"},
                          {"b", "#ROSBAG V2.0\n", "a ROS 1 bag"},
                          {"a.mcap", "\x89MCAP0\r\n", "a ROS 2 bag"},
                          {"a.db3", "SQLite format 3", "a ROS 2 bag"},
                          {"a.pcap", "x", "Velodyne capture"},
                          {"run.log", "FLASER 180 ...", "carmen2rawlog"},
                          {"run.clf", "FLASER 180 ...", "carmen2rawlog"},
                          {"a.LAZ", "LASF", "pdal translate"},
                          {"a.zip", "PK", "unpack it first"},
                          {"a.bt", "# Octomap OcTree binary file", "a map, not a recording"},
                          {"a.tum", "1 2 3", "give them with --poses"},
                          {"cloud", "# .PCD v0.7\n", "name it .pcd"},
                          {"a.txt", "hello", "a text file"},
                          {"empty", "", "an empty file"}}) {
        const auto message = errorOf(folder.write(c.name, c.contents));
        expectPart(message, "unknown input");
        expectPart(message, c.advice);
    }
    fs::create_directory(folder / "nothing");
    expectPart(errorOf(folder / "nothing"), "a folder without scans");
}

TEST(Formats, whatFollowsThePointsIsCheckedToo) {
    TempFolder folder;
    ScanSourceOptions fixed;
    fixed.poses = PoseOrigin::fixed;
    const auto digestOf = [&](const std::string& path) { return build(path, fixed).digest; };
    const std::string vertices = "property float x\nproperty float y\nproperty float z\n";
    const auto ply = [&](const std::string& format, const std::string& rest,
                         const std::string& data) {
        return folder.write("a.ply", "ply\nformat " + format + " 1.0\nelement vertex 1\n" +
                                         vertices + rest + "end_header\n" + data);
    };
    const std::string point("\0\0\x80\x3f\0\0\0\x40\0\0\x40\x40", 12);  // 1 2 3
    const auto expected = digestOf(ply("binary_little_endian", "", point));
    EXPECT_EQ(digestOf(ply("ascii", "", "1 2 3\n")), expected);
    EXPECT_EQ(digestOf(ply("ascii", "", "1 2 3\n\n")), expected);
    // Faces, as a mesh has them.
    const std::string faces = "element face 2\nproperty list uchar int vertex_indices\n";
    const std::string triangle = "\x03" + std::string(12, '\x01');
    EXPECT_EQ(digestOf(ply("binary_little_endian", faces, point + triangle + triangle)),
              expected);
    EXPECT_EQ(digestOf(ply("ascii", faces, "1 2 3\n3 0 0 0\n3 0 0 0\n")), expected);
    const auto error = [&](const std::string& path) { return errorOf(path, fixed); };
    const std::string le = "binary_little_endian";
    expectPart(error(ply(le, faces, point + triangle + triangle.substr(0, 12))), "ends early");
    expectPart(error(ply(le, faces, point + triangle)), "ends early");
    expectPart(error(ply(le, "", point + "x")), "other data follow");
    expectPart(error(ply(le, "element vertex 1\n" + vertices, point + point)),
               "second element vertex");
    expectPart(error(ply(le, "property float x\n", point + point)), "second property 'x'");
    expectPart(error(ply(le, "property list uchar int x2\n", point)), "a list");
    expectPart(error(ply("ascii", "", "1 2 3\n4 5 6\n")), "other data follow");
    // Many elements without properties take neither time nor memory.
    EXPECT_EQ(digestOf(ply(le, "element nothing 1000000000000000000\n", point)), expected);

    const auto pcd = [&](const std::string& header, const std::string& data) {
        return folder.write("a.pcd", "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n" + header + data);
    };
    const std::string one = "WIDTH 1\nHEIGHT 1\n";
    EXPECT_EQ(digestOf(pcd(one, "DATA binary\n" + point)), expected);
    EXPECT_EQ(digestOf(pcd(one, "DATA binary\n" + point + std::string(20, '\0'))), expected);
    expectPart(error(pcd(one, "DATA binary\n" + point + "x")), "other data follow");
    expectPart(error(pcd("WIDTH 1e12\nHEIGHT 1e12\n", "DATA binary\n" + point)), "at most 1e9");
    expectPart(error(pcd("COUNT 1 1 1e9\n" + one, "DATA binary\n" + point)), "1048576");
    // A literal run of 12 bytes; then one that has a byte more than is told.
    const auto lzf = [&](char packed, const std::string& data) {
        return std::string("DATA binary_compressed\n") + packed + std::string(3, '\0') +
               std::string("\x0c\0\0\0", 4) + data;
    };
    EXPECT_EQ(digestOf(pcd(one, lzf('\x0d', "\x0b" + point))), expected);
    expectPart(error(pcd(one, lzf('\x0e', "\x0b" + point + "x"))), "damaged");
    expectPart(error(pcd(one, lzf('\x0d', "\x0b" + point + "x"))), "other data follow");
}

/// What of a file that is cut can be seen.
enum class Cuts {
    seen,            ///< every cut
    seenBut16Bytes,  ///< of points without a header: not if whole points are left
    seenInCounts     ///< of lists: as fewer scans, where whole lines are left
};

/// A file of a sample that is broken, and how it is read.
struct Breakable {
    const char *recording, *file;
    Cuts cuts;
};

void PrintTo(const Breakable& b, std::ostream* out) {
    *out << b.recording << "/" << b.file;
}

class BrokenFormats : public testing::TestWithParam<Breakable> {
 protected:
    BrokenFormats() {
        const std::string name = GetParam().recording;
        // The poses of those that have none of their own are in the folder, too.
        fs::copy(sample(name), folder_ / name, fs::copy_options::recursive);
        fs::copy(sample("poses.tum"), folder_ / name);
        fs::copy(sample("poses.kitti"), folder_ / name);
        fs::copy(sample("global_pose.csv"), folder_ / name);
        input_ = folder_ / name;
        if (name == "kitti") input_ += "/sequences/07";
        if (name == "kitti_raw") input_ += "/2011_09_26_drive_0001_sync";
        if (name == "rgbd") {
            options_ = sampleCamera();
        } else if (name.rfind("kitti", 0) != 0) {
            const bool given = std::string(GetParam().file) == "poses.kitti";
            options_ = withPoses((folder_ / name) + (given              ? "/poses.kitti"
                                                     : name == "mulran" ? "/global_pose.csv"
                                                                        : "/poses.tum"));
        }
        whole_ = readWholeFile(folder_ / inFolder());
        expected_ = build(input_, options_);
    }
    static std::string inFolder() {
        return std::string(GetParam().recording) + "/" + GetParam().file;
    }
    /// Nothing if it is refused, in one line.
    std::optional<Built> buildWith(const std::string& bytes) {
        folder_.write(inFolder(), bytes);
        try {
            return build(input_, options_);
        } catch (const InputError& e) {
            EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
            return std::nullopt;
        }
    }

    TempFolder folder_;
    std::string input_, whole_;
    ScanSourceOptions options_;
    Built expected_;
};

/// Never a crash, never a hang; if it is read, then as the whole one (the file ended in
/// bytes that do not matter), or without what was left out.
TEST_P(BrokenFormats, truncatedAnywhere) {
    int refused = 0;
    for (std::size_t i = 0; i < 100; ++i) {
        const std::size_t length = whole_.size() * i / 100;
        const auto built = buildWith(whole_.substr(0, length));
        refused += !built;
        if (!built || built->digest == expected_.digest) continue;
        const bool isTold =
            (GetParam().cuts == Cuts::seenBut16Bytes && length % 16 == 0) ||
            (GetParam().cuts == Cuts::seenInCounts && built->scans < expected_.scans);
        EXPECT_TRUE(isTold) << "silently, at " << length;
    }
    EXPECT_GT(refused, 15);  // binary PCD is filled up to 4 kB
}

TEST_P(BrokenFormats, randomBytes) {
    std::mt19937 random(7);
    int refused = 0;
    for (int i = 0; i < 100; ++i) {
        auto broken = whole_;
        for (int k = i % 2 == 0 ? 100 : 1; k > 0; --k)
            broken[random() % broken.size()] = static_cast<char>(random());
        refused += !buildWith(broken);
    }
    const bool hasRules = GetParam().cuts != Cuts::seenBut16Bytes;  // any bytes are points
    EXPECT_GT(refused, hasRules ? 25 : -1);
}

INSTANTIATE_TEST_SUITE_P(
    Samples, BrokenFormats,
    testing::Values(
        Breakable{"pcd_ascii", "1000.500000.pcd", Cuts::seen},
        Breakable{"pcd_binary", "1000.500000.pcd", Cuts::seen},
        Breakable{"pcd_compressed", "1000.500000.pcd", Cuts::seen},
        Breakable{"ply_ascii", "1000.500000.ply", Cuts::seen},
        Breakable{"ply_binary", "1000.500000.ply", Cuts::seen},
        Breakable{"ply_binary", "poses.tum", Cuts::seenInCounts},
        Breakable{"ply_binary", "poses.kitti", Cuts::seen},
        Breakable{"mulran", "global_pose.csv", Cuts::seenInCounts},
        Breakable{"mulran", "1600001000500000000.bin", Cuts::seenBut16Bytes},
        Breakable{"rgbd", "depth/1000.500000.png", Cuts::seen},
        Breakable{"rgbd", "depth.txt", Cuts::seenInCounts},
        Breakable{"rgbd", "groundtruth.txt", Cuts::seenInCounts},
        Breakable{"kitti", "sequences/07/calib.txt", Cuts::seen},
        Breakable{"kitti", "sequences/07/times.txt", Cuts::seen},
        Breakable{"kitti", "sequences/07/velodyne/000001.bin", Cuts::seenBut16Bytes},
        Breakable{"kitti", "poses/07.txt", Cuts::seen},
        Breakable{"kitti_raw", "calib_imu_to_velo.txt", Cuts::seen},
        Breakable{"kitti_raw", "2011_09_26_drive_0001_sync/velodyne_points/timestamps.txt",
                  Cuts::seen},
        Breakable{"kitti_raw", "2011_09_26_drive_0001_sync/oxts/data/0000000001.txt",
                  Cuts::seen}));

}  // namespace
}  // namespace superray
