// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Files of every format that holds scans as they are, to be broken: what is read with them.

#include <gtest/gtest.h>
#include <octomap/ScanGraph.h>

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "eval/sources/format_samples.h"

namespace superray::test {

/// What of a file that is cut can be seen.
enum class Cuts {
    seen,            ///< every cut
    seenBut16Bytes,  ///< of points without a header: not if whole points are left
    seenInCounts,    ///< of lists: as fewer scans, where whole lines are left
    seenInPackets    ///< of captures: not if whole packets are left
};

/// A file of a sample that is broken, and how it is read.
struct Breakable {
    const char *recording, *file;
    Cuts cuts;
};

inline void PrintTo(const Breakable& b, std::ostream* out) {
    *out << b.recording << "/" << b.file;
}

inline std::vector<Breakable> breakables() {
    return {Breakable{"pcd_ascii", "1000.500000.pcd", Cuts::seen},
            Breakable{"pcd_binary", "1000.500000.pcd", Cuts::seen},
            Breakable{"pcd_compressed", "1000.500000.pcd", Cuts::seen},
            Breakable{"ply_ascii", "1000.500000.ply", Cuts::seen},
            Breakable{"ply_binary", "1000.500000.ply", Cuts::seen},
            Breakable{"las", "1000.500000.las", Cuts::seen},
            Breakable{"las_1_4", "1000.500000.las", Cuts::seen},
            Breakable{"velodyne", "plain.pcap", Cuts::seenInPackets},
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
                      Cuts::seen},
            Breakable{"graph", "scans.graph", Cuts::seen}};
}

/// A copy of a sample, of which one file can be written anew.
class BreakableCopy {
 public:
    explicit BreakableCopy(const Breakable& sampled) : what_(sampled) {
        namespace fs = std::filesystem;
        const std::string name = what_.recording;
        if (name == "graph")
            writeGraph();
        else
            fs::copy(sample(name), folder_ / name, fs::copy_options::recursive);
        // The poses of those that have none of their own are in the folder, too.
        for (const char* poses : {"poses.tum", "poses.kitti", "global_pose.csv"})
            fs::copy(sample(poses), folder_ / name);
        input_ = folder_ / name;
        if (name == "kitti") input_ += "/sequences/07";
        if (name == "kitti_raw") input_ += "/2011_09_26_drive_0001_sync";
        if (name == "velodyne") input_ += "/plain.pcap";
        if (name == "graph") input_ += "/scans.graph";
        if (name == "rgbd") options_ = sampleCamera();
        const bool hasPoses = name == "rgbd" || name == "graph" || name.rfind("kitti", 0) == 0;
        const std::string file = std::string(what_.file) == "poses.kitti" ? "/poses.kitti"
                                 : name == "mulran"                       ? "/global_pose.csv"
                                                                          : "/poses.tum";
        if (!hasPoses) options_ = withPoses((folder_ / name) + file);
        whole_ = readWholeFile(folder_ / inFolder());
    }

    const std::string& whole() const { return whole_; }

    /// \throws InputError if it is refused
    Built buildWith(const std::string& bytes) const {
        folder_.write(inFolder(), bytes);
        return build(input_, options_);
    }

    /// True if a cut at this length may leave a recording that looks whole.
    bool mayLookWhole(std::size_t length) const {
        constexpr std::size_t kPoint = 16, kFileHeader = 24, kPacket = 1264;
        return (what_.cuts == Cuts::seenBut16Bytes && length % kPoint == 0) ||
               (what_.cuts == Cuts::seenInPackets && length >= kFileHeader &&
                (length - kFileHeader) % kPacket == 0);
    }

 private:
    std::string inFolder() const { return std::string(what_.recording) + "/" + what_.file; }

    /// By OctoMap.
    void writeGraph() {
        octomap::ScanGraph graph;
        for (int i = 0; i < 3; ++i) {
            const auto points = sampleScan(i)->pointcloud;
            auto cloud = std::make_unique<octomap::Pointcloud>();
            for (std::size_t k = 0; k < points->size(); ++k) {
                float x = 0, y = 0, z = 0;
                points->getPoint(k, x, y, z);
                cloud->push_back(x, y, z);
            }
            const CPose3D pose = samplePose(i);
            graph.addNode(
                cloud.release(),
                octomap::pose6d(static_cast<float>(pose.x()), static_cast<float>(pose.y()),
                                static_cast<float>(pose.z()), 0, 0, 0));
        }
        std::filesystem::create_directory(folder_ / "graph");
        graph.writeBinary(folder_ / "graph/scans.graph");
    }

    Breakable what_;
    TempFolder folder_;
    std::string input_, whole_;
    ScanSourceOptions options_;
};

}  // namespace superray::test
