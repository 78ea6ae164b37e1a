// SPDX-License-Identifier: BSD-3-Clause
// Texts, folders and options that are cut, doubled or contradict themselves, and paths
// that never end: errors.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>
#include <superray/eval/map_request.h>
#include <superray/eval/octomap_file.h>
#include <superray/eval/scan_source.h>
#include <superray/eval/trajectory.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <sys/stat.h>

#include <octomap/OcTree.h>

#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;

TEST(BrokenInputs, PosesCutAnywhereAreAnErrorOrFewerPoses) {
    const TempFolder folder;
    const std::string text =
        "# t x y z qx qy qz qw\n1 0.5 0 0 0 0 0 1\n2 0.75 0 0 0 0 0 1\n"
        "3 10.125 -2.5 1e-3 0 0 0.6 0.8\n";
    const auto whole = Trajectory::load(folder.write("a.tum", text));
    ASSERT_EQ(whole.size(), 3u);
    int refused = 0;
    for (std::size_t size = 0; size < text.size(); ++size) {
        const auto path = folder.write("cut.tum", text.substr(0, size));
        try {
            const auto cut = Trajectory::load(path);
            for (const auto& [time, pose] : cut.poses()) EXPECT_EQ(pose, *whole.at(time));
        } catch (const InputError&) {
            ++refused;
        }
    }
    EXPECT_GE(refused, static_cast<int>(text.size()) - 3);
}

class BrokenKitti : public ::testing::Test {
 protected:
    TempFolder folder;
    const std::string pose = "1 0 0 0 0 1 0 0 0 0 1 0\n";

    BrokenKitti() {
        folder.write("k/calib.txt", "P0: 1 2\nTr: " + pose);
        folder.write("k/poses.txt", pose + pose);
        folder.write("k/times.txt", "0\n0.1\n");
        folder.write("k/velodyne/000000.bin", std::string(32, '\0'));
        folder.write("k/velodyne/000001.bin", std::string(32, '\0'));
    }
    std::string error() const {
        return messageOf<InputError>([&] { openScanSource(folder / "k", {}); });
    }
};

TEST_F(BrokenKitti, SamplesAreWhole) {
    EXPECT_EQ(error(), "no exception");
}

TEST_F(BrokenKitti, TwoFilesOfOneFrame) {
    folder.write("k/velodyne/1.bin", std::string(16, '\0'));
    EXPECT_NE(error().find("is there twice"), std::string::npos) << error();
}

TEST_F(BrokenKitti, TwoCalibrations) {
    folder.write("k/calib.txt", "Tr: " + pose + "Tr: " + pose);
    EXPECT_NE(error().find("second row 'Tr:'"), std::string::npos) << error();
}

TEST_F(BrokenKitti, WildTimes) {
    for (const char* time : {"1e300", "-1e300", "1e12", "nan", "inf"}) {
        folder.write("k/times.txt", std::string("0\n") + time + "\n");
        EXPECT_NE(error(), "no exception") << time;
    }
}

TEST_F(BrokenKitti, TextsThatAreCut) {
    for (const auto& [name, text] :
         {std::pair<std::string, std::string>("k/times.txt", "0\n0.1"),
          {"k/poses.txt", pose + "1 0 0 0 0 1 0 0 0 0 1 0"},
          {"k/calib.txt", "Tr: 1 0 0 0 0 1 0 0 0 0 1 1"}}) {
        const std::string before = readWholeFile(folder / name);
        folder.write(name, text);
        EXPECT_NE(error().find("its last line has no end"), std::string::npos) << error();
        folder.write(name, before);
    }
}

TEST(BrokenInputs, SecondSectionsAndKeysOfIniFiles) {
    const TempFolder folder;
    const auto errorOf = [&](const std::string& text) {
        MapRequest request;
        request.configFile = folder.write("a.ini", text);
        request.section = "m";
        return messageOf<std::exception>([&] { makeMap(request); });
    };
    EXPECT_EQ(errorOf("[m_insertOpts]\nprobHit = 0.8 # once\n; probHit = 0.9\n"),
              "no exception");
    EXPECT_NE(errorOf("[m_insertOpts]\nprobHit = 0.8\nPROBHIT=0.9\n").find("second key"),
              std::string::npos);
    EXPECT_NE(
        errorOf("[m_insertOpts]\nprobHit = 0.8\n[x]\n[m_insertOpts]\n").find("second section"),
        std::string::npos);
}

TEST(BrokenInputs, OptionsInMapFiles) {
    const TempFolder folder;
    const CSuperRayGridMap3D map(0.25);
    const auto errorOf = [&](const std::string& options) {
        MapFileHeader header{"CSuperRayGridMap3D", 3, 0.25, options};
        saveMapFile(folder / "a.srmap", header, encodeCells(map.storage()));
        return messageOf<MapFileError>(
            [&] { CSuperRayGridMap3D().loadFromFile(folder / "a.srmap"); });
    };
    EXPECT_EQ(errorOf(map.optionsAsIniText()), "no exception");
    EXPECT_EQ(errorOf(""), "no exception");
    EXPECT_NE(errorOf("[creationOpts]\nresolution = 0.5\n").find("in the header"),
              std::string::npos);
    EXPECT_NE(errorOf("[insertOpts]\nprobHit = 0.8\nprobHit = 0.9\n").find("second key"),
              std::string::npos);
    EXPECT_NE(errorOf("[insertOpts]\n[insertOpts]\n").find("second section"),
              std::string::npos);
}

TEST(BrokenInputs, WhatNeverEndsIsNoInput) {
    const TempFolder folder;
    ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
    std::filesystem::create_symlink("/dev/zero", folder / "zero");
    for (const char* target : {"fifo", "zero"}) {
        const auto named = [&](const std::string& extension) {
            const std::string path = folder / (target + extension);
            std::filesystem::create_symlink(folder / target, path);
            return path;
        };
        EXPECT_THROW(Trajectory::load(named(".tum")), InputError);
        EXPECT_THROW(readOctomapFile(named(".ot")), InputError);
        for (const char* extension : {".rawlog", ".simplemap", ".graph", ".pcd", ".PLY"})
            EXPECT_THROW(openScanSource(named(extension), {}), InputError) << extension;
        EXPECT_THROW(CSuperRayGridMap3D().loadFromFile(named(".srmap")), MapFileError);
        MapRequest request;
        request.configFile = named(".ini");
        request.section = "m";
        EXPECT_THROW(makeMap(request), InputError);
    }
}

TEST(BrokenInputs, AFewBytesDoNotBecomeAHugeMap) {
    const TempFolder folder;
    // One leaf of 512^3 cells.
    std::string bytes = "# Octomap OcTree file\nid OcTree\nsize 8\nres 0.1\ndata\n";
    for (int depth = 0; depth <= 7; ++depth) {
        bytes += std::string(4, '\0');
        bytes += depth < 7 ? '\x01' : '\0';
    }
    const auto path = folder.write("a.ot", bytes);
    const auto error = messageOf<InputError>([&] { readOctomapFile(path); });
    EXPECT_NE(error.find("stand for more than"), std::string::npos) << error;
    // The file is whole, and there is a way out.
    EXPECT_EQ(error.find("is not a whole"), std::string::npos) << error;
    EXPECT_NE(error.find("SUPERRAY_MAP_MEGABYTES"), std::string::npos) << error;
    ASSERT_EQ(::setenv("SUPERRAY_MAP_MEGABYTES", "700", 1), 0);
    EXPECT_EQ(readOctomapFile(path).map->geometry().resolution(), 0.1);
    ASSERT_EQ(::setenv("SUPERRAY_MAP_MEGABYTES", "600", 1), 0);
    EXPECT_THROW(readOctomapFile(path), InputError);
    ASSERT_EQ(::unsetenv("SUPERRAY_MAP_MEGABYTES"), 0);
    OctomapLimits limits;
    limits.cellsOfAnyFile = std::uint64_t{1} << 27;
    EXPECT_EQ(readOctomapFile(path, limits).map->geometry().resolution(), 0.1);
    limits.fileBytes = bytes.size() - 1;
    EXPECT_THROW(readOctomapFile(path, limits), InputError);
}

}  // namespace
}  // namespace superray
