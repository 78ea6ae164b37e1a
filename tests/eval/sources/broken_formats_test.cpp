// SPDX-License-Identifier: BSD-3-Clause
// Files of every format, cut anywhere or with other bytes: never a crash, never mapped
// silently as if whole.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>

#include <filesystem>
#include <optional>
#include <ostream>
#include <random>

#include "eval/sources/format_samples.h"

namespace superray {
namespace {

namespace fs = std::filesystem;
using namespace test;

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
    if (hasRules) {
        EXPECT_GT(refused, 25);
    }
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
