// SPDX-License-Identifier: BSD-3-Clause
// A walk through a synthetic room: trajectory, key frames, priors.

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CRawlog.h>
#include <superray/eval/input_error.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/slam/range_slam.h>
#include <superray/slam/slam_output.h>
#include <superray/slam/trajectory_error.h>

#include "eval/temp_folder.h"
#include "slam/synthetic_room.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

constexpr int kScans = 24;

TSlamOptions roomOptions() {
    TSlamOptions o;
    o.registration.resolutions = "0.6, 0.3";
    o.registration.pointSpacing = 0.15;
    o.keyFrames.insertionLinDistance = 0.3;
    o.keyFrames.insertionAngDistance = 15;
    return o;
}

std::shared_ptr<CSuperRayGridMap3D> emptyMap() {
    return std::make_shared<CSuperRayGridMap3D>(0.2);
}

Trajectory truth() {
    Trajectory t;
    for (int i = 0; i < kScans; ++i)
        t.add(mrpt::Clock::fromDouble(1e9 + 0.2 * i), test::roomPose(i));
    return t;
}

TEST(RangeSlam, WalksThroughTheRoom) {
    const auto map = emptyMap();
    RangeSlam slam(roomOptions(), map);
    int inserted = 0, processed = 0;
    for (int i = 0; i < kScans; ++i) {
        Scan scan = test::roomScan(test::roomPose(i), 0.2 * i, static_cast<std::uint32_t>(i));
        scan.T_map_robot = CPose3D(100 * i, 7, 7, 1, 1, 1);  // must not be used
        const auto step = slam.process(scan);
        ASSERT_TRUE(step);
        inserted += step->inserted;
        ++processed;
    }
    ASSERT_EQ(processed, kScans);
    const auto error = compareTrajectories(slam.trajectory(), truth());
    EXPECT_EQ(error.poses, static_cast<std::size_t>(kScans));
    EXPECT_LT(error.absolute.rmse, 0.01);
    EXPECT_LT(error.drift(), 0.01);
    EXPECT_GT(inserted, 3);
    EXPECT_LT(inserted, kScans / 2);
    EXPECT_EQ(slam.keyFrames().size(), static_cast<std::size_t>(inserted));
    EXPECT_EQ(map->totals().scans, static_cast<std::uint64_t>(inserted));
    EXPECT_GT(map->cellTotals().occupied, 500u);
}

TEST(RangeSlam, StartsWhereItIsTold) {
    const CPose3D start(10, 20, 1, 0.5, 0.02, -0.03);
    RangeSlam slam(roomOptions(), emptyMap(), start);
    for (int i = 0; i < 6; ++i)
        slam.process(test::roomScan(test::roomPose(i), 0.2 * i, static_cast<std::uint32_t>(i)));
    const auto& poses = slam.trajectory().poses();
    EXPECT_EQ(poses.begin()->second, start);
    const CPose3D expected = start + (test::roomPose(5) - test::roomPose(0));
    EXPECT_LT(poses.rbegin()->second.distanceTo(expected), 0.02);
}

TEST(RangeSlam, OdometryTakesTheStartOverGaps) {
    // Every 12th pose: 31 degrees apart, too far for registration alone.
    TSlamOptions options = roomOptions();
    options.keyFrames.prior = MotionPrior::odometry;
    RangeSlam slam(options, emptyMap());
    const CPose3D T_odometry_map(5, 5, 0, 1, 0, 0);  // another origin, as odometry has
    for (int i = 0; i < 4; ++i) {
        Scan scan = test::roomScan(test::roomPose(12 * i), i, static_cast<std::uint32_t>(i));
        scan.T_map_robot =
            T_odometry_map + test::roomPose(12 * i) + CPose3D(0.03, 0, 0, 0, 0, 0);
        slam.process(scan);
    }
    const CPose3D expected = test::roomPose(36) - test::roomPose(0);
    EXPECT_LT(slam.trajectory().poses().rbegin()->second.distanceTo(expected), 0.02);
}

TEST(RangeSlam, ScansThatDoNotAgreeAreNotInserted) {
    TSlamOptions options = roomOptions();
    options.keyFrames.prior = MotionPrior::none;
    const auto map = emptyMap();
    RangeSlam slam(options, map);
    slam.process(test::roomScan(test::roomPose(0), 0, 1));
    Scan elsewhere = test::roomScan(test::roomPose(0), 1, 2);
    auto& cloud =
        *dynamic_cast<mrpt::obs::CObservationPointCloud&>(*elsewhere.observation).pointcloud;
    std::mt19937 random(3);
    std::uniform_real_distribution<float> anywhere(-60, 60);
    for (std::size_t i = 0; i < cloud.size(); ++i)
        cloud.setPoint(i, anywhere(random), anywhere(random), anywhere(random));
    const auto step = slam.process(elsewhere);
    ASSERT_TRUE(step);
    EXPECT_LT(step->registration.goodness, 0.4);
    EXPECT_FALSE(step->inserted);
    EXPECT_EQ(map->totals().scans, 1u);
}

/// A recording of the walk.
std::string writeRawlog(const test::TempFolder& folder, const std::string& name,
                        bool withPoses) {
    mrpt::obs::CRawlog rawlog;
    for (int i = 0; i < 8; ++i) {
        const Scan scan =
            test::roomScan(test::roomPose(i), 0.2 * i, static_cast<std::uint32_t>(i));
        if (withPoses) {
            auto pose = mrpt::obs::CObservationRobotPose::Create();
            pose->timestamp = scan.timestamp;
            pose->pose.mean = CPose3D(3.0 * i, 50, 0, 2, 0, 0);  // wrong on purpose
            rawlog.insert(pose);
        }
        auto odometry = mrpt::obs::CObservationOdometry::Create();
        odometry->timestamp = scan.timestamp;
        odometry->odometry = mrpt::poses::CPose2D(test::roomPose(i));
        rawlog.insert(odometry);
        rawlog.insert(scan.observation);
    }
    const std::string path = folder / name;
    if (!rawlog.saveToRawLogFile(path)) throw std::runtime_error("cannot write " + path);
    return path;
}

Trajectory runOn(const std::string& path, PoseOrigin origin, MotionPrior prior) {
    TSlamOptions options = roomOptions();
    options.keyFrames.prior = prior;
    ScanSourceOptions sourceOptions;
    sourceOptions.poses = origin;
    const auto source = openScanSource(path, sourceOptions);
    RangeSlam slam(options, emptyMap());
    int calls = 0;
    const auto report =
        runSlam(*source, slam, options, [&](const SlamReport&, const SlamStep&) { ++calls; });
    EXPECT_EQ(calls, 8);
    EXPECT_EQ(report.scans, 8u);
    EXPECT_EQ(report.weak, 0u);
    return slam.trajectory();
}

TEST(RangeSlam, RobotPosesOfARecordingAreNotUsed) {
    const test::TempFolder folder;
    const auto with = writeRawlog(folder, "with.rawlog", true);
    const auto without = writeRawlog(folder, "without.rawlog", false);
    const std::pair<PoseOrigin, MotionPrior> ways[] = {
        {PoseOrigin::fixed, MotionPrior::constantVelocity},
        {PoseOrigin::odometry, MotionPrior::odometry}};
    for (const auto& [origin, prior] : ways) {
        runOn(with, origin, prior).saveTum(folder / "with.tum");
        runOn(without, origin, prior).saveTum(folder / "without.tum");
        EXPECT_EQ(test::readWholeFile(folder / "with.tum"),
                  test::readWholeFile(folder / "without.tum"));
        const auto error = compareTrajectories(Trajectory::load(folder / "with.tum"), truth());
        EXPECT_LT(error.absolute.rmse, 0.01);
    }
}

TEST(RangeSlam, OutputsAreWholeFiles) {
    const test::TempFolder folder;
    RangeSlam slam(roomOptions(), emptyMap());
    for (int i = 0; i < 3; ++i)
        slam.process(test::roomScan(test::roomPose(i), 0.2 * i, static_cast<std::uint32_t>(i)));
    for (const char* name : {"a.tum", "a.srmap", "a.simplemap", "a.3Dscene"}) {
        checkSlamOutputPath(folder / name);
        writeSlamOutput(slam, folder / name);
    }
    EXPECT_EQ(Trajectory::load(folder / "a.tum").size(), 3u);
    CSuperRayGridMap3D map;
    map.loadFromFile(folder / "a.srmap");
    EXPECT_EQ(map.digest(), dynamic_cast<const CSuperRayGridMap3D&>(slam.map()).digest());
    mrpt::maps::CSimpleMap frames;
    EXPECT_TRUE(frames.loadFromFile(folder / "a.simplemap"));
    EXPECT_EQ(frames.size(), slam.keyFrames().size());
    ScanSourceOptions odometry;
    odometry.poses = PoseOrigin::odometry;
    EXPECT_THROW(openScanSource(folder / "a.simplemap", odometry), InputError);
    EXPECT_GT(std::filesystem::file_size(folder / "a.3Dscene"), 1000u);
    for (const auto& entry : std::filesystem::directory_iterator(folder / ""))
        EXPECT_NE(entry.path().extension(), ".part");
    EXPECT_THROW(checkSlamOutputPath(folder / "a.txt"), InputError);
    EXPECT_THROW(checkSlamOutputPath(folder / "no/a.tum"), InputError);
}

}  // namespace
}  // namespace superray
