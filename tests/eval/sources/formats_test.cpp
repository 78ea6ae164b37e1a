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

#include "eval/sources/format_samples.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

namespace fs = std::filesystem;
using namespace test;
using mrpt::poses::CPose3D;

std::string errorOf(const std::string& path, const ScanSourceOptions& options = {}) {
    return messageOf<InputError>([&] { build(path, options); });
}

TEST(Formats, pointCloudFilesGiveTheMapOfTheRawlog) {
    const auto expected = expectedDigest();
    for (const char* name : {"pcd_ascii", "pcd_binary", "pcd_compressed", "ply_ascii",
                             "ply_binary", "las", "las_1_4"})
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

/// A cloud of one point, at x. \param kind "float" or "double"
std::string binaryPly(const std::string& kind, double x) {
    std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex 1\n";
    for (const char* axis : {"x", "y", "z"}) bytes += "property " + kind + " " + axis + "\n";
    bytes += "end_header\n";
    for (const double value : {x, 1.0, 0.5}) {
        const auto single = static_cast<float>(value);
        if (kind == "double")
            bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
        else
            bytes.append(reinterpret_cast<const char*>(&single), sizeof single);
    }
    return bytes;
}

std::string textPcd(const std::string& x) {
    return "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\n"
           "HEIGHT 1\nPOINTS 1\nDATA ascii\n" +
           x + " 1 0.5\n";
}

TEST(Formats, coordinatesOfACountryAreRefused) {
    TempFolder folder;
    ScanSourceOptions fixed;
    fixed.poses = PoseOrigin::fixed;
    const auto error = [&](const std::string& name, const std::string& bytes) {
        return messageOf<InputError>([&] { build(folder.write(name, bytes), fixed); });
    };
    for (const double x : {431234.56, -431234.5, 5.6e6}) {
        const auto message = error("a.ply", binaryPly("double", x));
        expectPart(message, "a.ply: has points at x " + std::string(x < 0 ? "-" : ""));
        expectPart(message, "las2las -translate_xyz, or pdal translate");
    }
    expectPart(error("a.pcd", textPcd("431234.56")), "a.pcd: has points at x 431234.56 m");
    const std::string textPly =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\n"
        "property double z\nend_header\n431234.56 1 0.5\n";
    expectPart(error("b.ply", textPly), "b.ply: has points at x 431234.56 m");
    const float far[] = {1, 2, 0, 0, 3, 40000, 1, 0};
    folder.write("bins/1000.bin", std::string(reinterpret_cast<const char*>(far), sizeof far));
    expectPart(errorOf(folder / "bins", fixed), "1000.bin: has points at y 40000 m");
    // Values that tell of no point are skipped.
    const auto one = build(folder.write("a.pcd", textPcd("2.3456789")), fixed).digest;
    const auto textPlyWith = [&](const std::string& second) {
        auto bytes = textPly.substr(0, textPly.find("431234.56")) + "2.3456789 1 0.5\n" +
                     second + " 1 0.5\n";
        return bytes.replace(bytes.find("vertex 1"), 8, "vertex 2");
    };
    for (const char* word : {"banana", "nanny", "1.5x", "", "+-5"})
        EXPECT_NE(error("c.ply", textPlyWith(word)), "no exception") << word;
    // Those are coordinates.
    const auto same = build(folder.write("c.ply", textPlyWith("0.5")), fixed).digest;
    EXPECT_EQ(build(folder.write("c.ply", textPlyWith("+0.5")), fixed).digest, same);
    EXPECT_EQ(build(folder.write("c.ply", textPlyWith("1e-400")), fixed).digest,
              build(folder.write("d.ply", textPlyWith("0")), fixed).digest);
    for (const char* x : {"nan", "NAN", "-nan(ind)", "inf", "-inf", "1e400", "1e9", "-1e300"}) {
        EXPECT_EQ(build(folder.write("c.ply", textPlyWith(x)), fixed).digest, one) << x;
        auto two = textPcd("2.3456789");
        for (const std::string key : {"WIDTH", "POINTS"})
            two.replace(two.find(key + " 1"), key.size() + 2, key + " 2");
        EXPECT_EQ(build(folder.write("a.pcd", two + x + " 1 0.5\n"), fixed).digest, one) << x;
    }
    // Rounding to single precision is no loss.
    EXPECT_EQ(build(folder.write("a.pcd", textPcd("2.3456789")), fixed).scans, 1u);
    EXPECT_EQ(build(folder.write("a.ply", binaryPly("double", 2.3456789)), fixed).digest,
              build(folder.write("b.ply", binaryPly("float", 2.3456789)), fixed).digest);
}

TEST(Formats, secondHeaderLinesAndFieldsAreRefused) {
    TempFolder folder;
    ScanSourceOptions fixed;
    fixed.poses = PoseOrigin::fixed;
    const auto withLine = [&](const std::string& line) {
        auto text = textPcd("1");
        text.insert(text.find("POINTS"), line + "\n");
        return errorOf(folder.write("a.pcd", text), fixed);
    };
    EXPECT_EQ(withLine("# FIELDS z y x"), "no exception");
    for (const std::string line :
         {"FIELDS z y x", "SIZE 4 4 4", "TYPE I I I", "COUNT 1 1 1", "WIDTH 1", "HEIGHT 1",
          "POINTS 1", "VIEWPOINT 0 0 0 1 0 0 0\nVIEWPOINT 5 0 0 1 0 0 0"})
        expectPart(withLine(line), "a second line " + line.substr(0, line.find(' ')));
    const auto fourFields = [&](const std::string& fourth) {
        auto text = textPcd("7 1");
        for (const auto& [from, to] : {std::pair<std::string, std::string>("x y z", "? x y z"),
                                       {"8 8 8", "8 8 8 8"},
                                       {"F F F", "F F F F"},
                                       {"1 1 1", "1 1 1 1"}})
            text.replace(text.find(from), from.size(), to);
        text.replace(text.find('?'), 1, fourth);
        return errorOf(folder.write("a.pcd", text), fixed);
    };
    EXPECT_EQ(fourFields("_"), "no exception");
    for (const std::string name : {"x", "y", "z"})
        expectPart(fourFields(name), "a second field '" + name + "'");
    auto ply = binaryPly("float", 1);
    ply.insert(ply.find("element"), "format ascii 1.0\n");
    expectPart(errorOf(folder.write("a.ply", ply), fixed), "a second line format");
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
    ScanSourceOptions other = sampleCamera();
    other.depthCamera.fx = 40;
    EXPECT_NE(build(sample("rgbd"), other).digest, expected) << "the camera must matter";
    expectPart(errorOf(sample("rgbd")), "is one of 640 x 480; give its camera (--intrinsics)");
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
    for (const Case& c : {Case{"a.mcap.zstd", "\x28\xb5\x2f\xfd", "'zstd -d'"},
                          {"capture", "\xd4\xc3\xb2\xa1", "name it .pcap"},
                          {"scan", "LASF", "name it .las"},
                          {"a.ply.gz", "\x1f\x8b", "unpack it"},
                          {"run.log", "FLASER 180 ...", "carmen2rawlog"},
                          {"run.clf", "FLASER 180 ...", "carmen2rawlog"},
                          {"a.zip", "PK", "unpack it first"},
                          {"scan.dat.bz2", "BZh9", "unpack it first"},
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

}  // namespace
}  // namespace superray
