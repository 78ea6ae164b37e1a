// SPDX-License-Identifier: BSD-3-Clause
// Folders of a scan a file: their order, their times, and which pose belongs to which file.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>
#include <superray/eval/scan_source.h>

#include <cmath>
#include <ostream>

#include "eval/recorded_scans.h"
#include "eval/sources/format_samples.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;

/// A scan of one point, at x.
std::string cloudAt(int x) {
    return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
           "POINTS 1\nDATA ascii\n" +
           std::to_string(x) + " 1 1\n";
}

std::string binAt(int x) {
    const float point[4] = {static_cast<float>(x), 1, 1, 0};
    return {reinterpret_cast<const char*>(point), sizeof point};
}

struct Read {
    int scan;     ///< x of its point
    double pose;  ///< x of the robot
    double seconds;
    bool operator==(const Read& other) const {
        return scan == other.scan && pose == other.pose &&
               std::abs(seconds - other.seconds) < 1e-6;
    }
};

std::ostream& operator<<(std::ostream& out, const Read& r) {
    return out << "scan " << r.scan << " at " << r.pose << " m, " << r.seconds << " s";
}

std::vector<Read> readAll(const std::string& path, const ScanSourceOptions& options) {
    const auto source = openScanSource(path, options);
    std::vector<Read> scans;
    while (const auto scan = source->next())
        scans.push_back({static_cast<int>(pointsOf(*scan->observation).at(0)),
                         scan->T_map_robot.x(), mrpt::Clock::toDouble(scan->timestamp)});
    return scans;
}

std::string errorOf(const std::string& path, const ScanSourceOptions& options) {
    return messageOf<InputError>([&] { readAll(path, options); });
}

ScanSourceOptions fixedRobot() {
    ScanSourceOptions options;
    options.poses = PoseOrigin::fixed;
    return options;
}

/// As many poses of KITTI's 12 columns: at 0 m, 1 m, ...
std::string poseRows(int count) {
    std::string rows;
    for (int i = 0; i < count; ++i) rows += "1 0 0 " + std::to_string(i) + " 0 1 0 0 0 0 1 0\n";
    return rows;
}

constexpr double kDrive = 1317042120;  // 2011-09-26 13:02:00 UTC

/// A KITTI raw drive with these scans, and these rows of times.
std::string rawDrive(const TempFolder& folder, const std::vector<std::string>& scans,
                     const std::string& times) {
    static int drives = 0;
    const std::string drive = "drive" + std::to_string(++drives);
    for (const auto& name : scans)
        folder.write(drive + "/velodyne_points/data/" + name + ".bin", binAt(std::stoi(name)));
    folder.write(drive + "/velodyne_points/timestamps.txt", times);
    return folder / drive;
}

const std::string kFourTimes =
    "2011-09-26 13:02:00.000000000\n2011-09-26 13:02:01.250000000\n"
    "2011-09-26 13:02:02.000000000\n2011-09-26 13:02:03.000000000\n";

TEST(FrameFolders, timesOfARawDriveGoToScansByTheirNumber) {
    TempFolder folder;
    const auto drive = rawDrive(folder, {"0000000000", "0000000002", "0000000003"}, kFourTimes);
    const std::vector<Read> expected{{0, 0, kDrive}, {2, 2, kDrive + 2}, {3, 3, kDrive + 3}};
    std::string tum;
    for (int i = 0; i < 4; ++i)
        tum += std::to_string(1317042120 + i) + " " + std::to_string(i) + " 0 0 0 0 0 1\n";
    EXPECT_EQ(readAll(drive, withPoses(folder.write("a.tum", tum))), expected);
    EXPECT_EQ(readAll(drive, withPoses(folder.write("a.txt", poseRows(4)))), expected);
    // What no number can tell is refused.
    const auto fewer = rawDrive(folder, {"0000000000", "0000000004"}, kFourTimes);
    expectPart(errorOf(fewer, fixedRobot()), "has 4 times for 5 frames");
    const auto twice = rawDrive(folder, {"0", "0000000000"}, kFourTimes);
    expectPart(errorOf(twice, fixedRobot()), "is there twice");
    const auto named = rawDrive(folder, {"0000000000", "1st"}, kFourTimes);
    expectPart(errorOf(named, fixedRobot()), "is not named by its frame number");
}

TEST(FrameFolders, timesOfARawDriveAreReadStrictly) {
    TempFolder folder;
    const auto timeOf = [&](const std::string& time) {
        return readAll(rawDrive(folder, {"0"}, time + "\n"), fixedRobot()).at(0).seconds;
    };
    EXPECT_NEAR(timeOf("2011-09-26 13:02:00.900000000"), kDrive + 0.9, 1e-6);
    EXPECT_NEAR(timeOf("2011-09-26 13:02:00.9\r"), kDrive + 0.9, 1e-6);
    EXPECT_NEAR(timeOf("2011-09-26 13:02:00"), kDrive, 1e-6);
    EXPECT_NEAR(timeOf("2012-02-29 00:00:00.0"), 1330473600, 1e-6);
    for (const std::string bad : {"2011-09-26 13:02:00,900000000",
                                  "2011-09-26 13:02:00junk",
                                  "2011-45-26 13:02:00",
                                  "2011-09-26 60:60:00",
                                  "2011-09-26 13:02:0x5",
                                  "2011-09-26 13:02:60",
                                  "2011-09-26 24:00:00",
                                  "2011-09-26 13:60:00",
                                  "2011-09-31 13:02:00",
                                  "2011-02-29 13:02:00",
                                  "2011-00-26 13:02:00",
                                  "2011-09-00 13:02:00",
                                  "2011-9-26 13:02:00",
                                  "2011-09-26 13:02:00.",
                                  "2011-09-26 13:02:00.5 1",
                                  "2011-9--1 13:02:0",
                                  "2011-09-26 13:02",
                                  "2011-09-26T13:02:00",
                                  "+011-09-26 13:02:00",
                                  "1969-09-26 13:02:00",
                                  "2011-09-26 13:02:nan",
                                  "2011-09-26"}) {
        const auto drive = rawDrive(folder, {"0", "1"}, "2011-09-26 13:02:00.0\n" + bad + "\n");
        const auto message = errorOf(drive, fixedRobot());
        expectPart(message, "timestamps.txt:2: time '" + bad + "' must be YYYY-MM-DD hh:mm:ss");
    }
}

TEST(FrameFolders, posesWithoutTimesGoToScansByTheirNumberOrNotAtAll) {
    TempFolder folder;
    const auto clouds = [&](const std::string& name, const std::vector<std::string>& stems) {
        for (const auto& stem : stems)
            folder.write(name + "/" + stem + ".pcd", cloudAt(std::stoi(stem)));
        return folder / name;
    };
    const auto poses = [&](int count) {
        return withPoses(folder.write("poses.txt", poseRows(count)));
    };
    const auto places = [&](const std::string& path, int count) {
        std::vector<double> x;
        for (const Read& r : readAll(path, poses(count))) x.push_back(r.pose);
        return x;
    };
    using Places = std::vector<double>;
    const auto numbered = clouds("numbered", {"000000", "000002", "000003"});
    EXPECT_EQ(places(numbered, 4), (Places{0, 2, 3}));
    EXPECT_EQ(places(numbered, 9), (Places{0, 2, 3}));
    EXPECT_EQ(places(numbered, 3), (Places{0, 1, 2})) << "as many poses as scans: by order";
    expectPart(openScanSource(numbered, poses(4))->poses().asText(),
               "4, paired with the scans "
               "by the numbers of the files");
    expectPart(openScanSource(numbered, poses(3))->poses().asText(), "by their order");
    // Times, other numbers, other names: nothing tells which pose is left over.
    for (const auto& path :
         {clouds("timed", {"100.5", "101.5", "102.5"}), clouds("far", {"0", "1", "7"}),
          clouds("signed", {"-1", "1", "2"}), clouds("fractions", {"0.5", "1", "2"})}) {
        EXPECT_EQ(places(path, 3), (Places{0, 1, 2})) << path;
        const auto message = errorOf(path, poses(4));
        expectPart(message, "poses.txt: has 4 poses for 3 scans of " + path);
    }
    expectPart(errorOf(numbered, poses(2)),
               "poses.txt: has 2 poses for 3 scans of " + numbered);
    expectPart(errorOf(clouds("far", {}), poses(4)), "files numbered 0 to 3");
}

TEST(FrameFolders, timesThatDoNotMeetTheScansAreNotAnOrder) {
    TempFolder folder;
    const auto tum = [&](int first) {
        std::string rows;
        for (int i = first; i < first + 3; ++i)
            rows += std::to_string(i) + " " + std::to_string(i) + " 0 0 0 0 0 1\n";
        return withPoses(folder.write("poses.tum", rows));
    };
    for (int i = 0; i < 3; ++i) {
        const auto number = std::to_string(i);
        folder.write("timed/10" + number + ".000000.pcd", cloudAt(i));
        folder.write("epoch/131704212" + number + ".pcd", cloudAt(i));
        folder.write("bins/160000100" + number + "000000000.bin", binAt(i));
        folder.write("numbered/00000" + number + ".pcd", cloudAt(i));
        folder.write("named/scan_" + number + ".pcd", cloudAt(i));
    }
    const auto drive = rawDrive(folder, {"0", "1", "2"}, kFourTimes);
    for (const auto& path : {folder / "timed", folder / "epoch", folder / "bins", drive}) {
        const auto message = errorOf(path, tum(500));
        expectPart(message, "no pose is at the time of a scan: poses 500.000 to 502.000 s");
        expectPart(message, "in 12 columns");
    }
    EXPECT_EQ(readAll(folder / "timed", tum(100)),
              (std::vector<Read>{{0, 100, 100}, {1, 101, 101}, {2, 102, 102}}));
    // Numbers of frames, and other names, tell no time.
    for (const auto& path : {folder / "numbered", folder / "named"}) {
        const auto scans = readAll(path, tum(500));
        ASSERT_EQ(scans.size(), 3u) << path;
        for (int i = 0; i < 3; ++i) EXPECT_EQ(scans[static_cast<std::size_t>(i)].pose, 500 + i);
        expectPart(openScanSource(path, tum(500))->poses().asText(), "by their order");
    }
    // Here the numbers of some files are times of poses, by chance.
    const auto often =
        folder.write("often.tum", "0 0 0 0 0 0 0 1\n0.5 1 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n");
    expectPart(errorOf(folder / "numbered", withPoses(often)), "but only 2 at the times");
    // A row that was skipped may have been any scan's.
    const std::string rows = "500 0 0 0 0 0 0 1\n501 nan 0 0 0 0 0 1\n";
    const auto skipped =
        folder.write("nan.tum", rows + "502 2 0 0 0 0 0 1\n503 3 0 0 0 0 0 1\n");
    expectPart(errorOf(folder / "numbered", withPoses(skipped)), "no pose is at the time");
}

TEST(FrameFolders, scansAreInTheOrderOfTheNumbersInTheirNames) {
    TempFolder folder;
    for (int i = 1; i <= 11; ++i) {
        const auto number = std::to_string(i);
        folder.write("a/scan_" + number + ".pcd", cloudAt(i));
        folder.write("b/" + number + "_scan.pcd", cloudAt(i));
        folder.write("c/run2_scan" + number + ".las.pcd", cloudAt(i));
        folder.write("d/lidar" + number + ".bin", binAt(i));
    }
    for (const char* name : {"a", "b", "c", "d"}) {
        const auto scans = readAll(folder / name, fixedRobot());
        ASSERT_EQ(scans.size(), 11u);
        for (int i = 0; i < 11; ++i)
            EXPECT_EQ(scans[static_cast<std::size_t>(i)].scan, i + 1) << name;
    }
    // Fractions are by value, too: 1.5 is after 1.25; and one name is before its longer ones.
    const std::vector<std::string> ordered{"s",
                                           "s_1.25",
                                           "s_1.5",
                                           "s_02",
                                           "s_2",
                                           "s_3a",
                                           "s_3b",
                                           "s_99999999999999999999998",
                                           "s_99999999999999999999999"};
    for (std::size_t i = 0; i < ordered.size(); ++i)
        folder.write("e/" + ordered[i] + ".pcd", cloudAt(static_cast<int>(i)));
    const auto scans = readAll(folder / "e", fixedRobot());
    ASSERT_EQ(scans.size(), ordered.size());
    for (std::size_t i = 0; i < scans.size(); ++i)
        EXPECT_EQ(scans[i].scan, static_cast<int>(i)) << ordered[i];
}

TEST(FrameFolders, oneScanTwiceIsRefused) {
    TempFolder folder;
    const auto refused = [&](const std::string& name, const std::vector<std::string>& files) {
        for (const auto& file : files)
            folder.write(name + "/" + file, file.back() == 'n' ? binAt(1) : cloudAt(1));
        const auto message = errorOf(folder / name, fixedRobot());
        for (const auto& file : files) expectPart(message, folder / (name + "/" + file));
        return message;
    };
    expectPart(refused("a", {"100.pcd", "100.0.pcd"}), "two scans of one time, 100.000 s");
    expectPart(refused("b", {"0.pcd", "000.pcd"}), "two scans of one time");
    expectPart(refused("c", {"1600001000.bin", "1600001000000000000.bin"}), "of one time");
    expectPart(refused("d", {"first.pcd", "first.PCD"}), "two scans of one name");
    // A repeated row of a list of images.
    const auto png = readWholeFile(sample("rgbd/depth/1000.000000.png"));
    folder.write("rgbd/depth/a.png", png);
    folder.write("rgbd/depth/b.png", png);
    const auto listed = [&](const std::string& rows) {
        folder.write("rgbd/depth.txt", rows);
        auto options = sampleCamera();
        options.poses = PoseOrigin::fixed;
        return messageOf<InputError>([&] { openScanSource(folder / "rgbd", options); });
    };
    EXPECT_EQ(listed("1 depth/a.png\n2 depth/b.png\n"), "no exception");
    expectPart(listed("1 depth/a.png\n2 depth/b.png\n1 depth/a.png\n"), "depth/a.png");
    expectPart(listed("1 depth/a.png\n1.0 depth/b.png\n"), "two scans of one time, 1.000 s");
    expectPart(listed("1 depth/a.png\n2 depth/a.png\n"), "two scans of one name");
}

}  // namespace
}  // namespace superray
