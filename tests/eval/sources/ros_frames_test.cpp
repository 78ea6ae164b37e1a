// SPDX-License-Identifier: BSD-3-Clause
// Where the robot and its sensors are, by the transforms and poses of a ROS recording.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>

#include <cmath>
#include <limits>
#include <utility>

#include "eval/sources/pose_matchers.h"
#include "eval/sources/ros_recording_in_memory.h"
#include "eval/sources/ros_samples.h"

namespace superray {
namespace {

using namespace test;
using mrpt::poses::CPose3D;

CPose3D ahead(double x, double yaw = 0) {
    return CPose3D(x, 0, 0, yaw, 0, 0);
}

CPose3D mountOf(const Recording& recording, const std::string& frame, double seconds) {
    return recording.robot()
        .mounts.at(frame)
        .at(at(kStart + seconds), Recording::limits())
        .pose.value();
}

TEST(RosFrames, sensorsAreWhereAChainOfTransformsSays) {
    Recording r;
    r.fixed("/base_link", "/mast", 1, M_PI / 2);
    r.fixed("mast", "lidar", 2);
    r.cloud(1, "/lidar");
    EXPECT_EQ(r.robot().name, "base_link");
    expectPoseNear(mountOf(r, "lidar", 1), CPose3D(1, 2, 0, M_PI / 2, 0, 0));
}

TEST(RosFrames, aSensorBesideTheRobotsFrameIsReachedDownwards) {
    Recording r;
    r.fixed("base_footprint", "base_link", 0.5);
    r.fixed("base_footprint", "lidar", 2);
    r.cloud(1, "lidar");
    EXPECT_EQ(r.robot().name, "base_link");
    expectPoseNear(mountOf(r, "lidar", 1), ahead(1.5));
}

TEST(RosFrames, aSensorThatMovesOnTheRobotIsFollowed) {
    Recording r;
    r.tf(0, "base_link", "scanner", 1, 0.0);
    r.tf(1, "base_link", "scanner", 1, 0.5);
    r.cloud(0.5, "scanner");
    expectPoseNear(mountOf(r, "scanner", 0.5), ahead(1, 0.25));
    // Not where nothing is known, nor over a gap.
    r.tf(9, "base_link", "scanner", 1, 0.5);
    const auto answer = r.robot().mounts.at("scanner").at(at(kStart + 5), Recording::limits());
    EXPECT_EQ(answer.result, PoseAnswer::Result::inGap);
}

TEST(RosFrames, transformsThatNeverChangeHoldAtAllTimes) {
    // As the first static_transform_publisher sent them.
    Recording r;
    for (int i = 0; i < 50; ++i) r.tf(100 + 0.1 * i, "base_link", "laser", 0.75);
    r.cloud(1, "laser");
    expectPoseNear(mountOf(r, "laser", 1), ahead(0.75));
}

TEST(RosFrames, cloudsInAFrameThatTheRobotMovesInAreRefused) {
    Recording r;
    for (int i = 0; i < 3; ++i) r.tf(i, "odom", "base_link", i);
    r.cloud(1, "odom", "/registered");
    expectPart(r.error(), "'/registered' are in the frame 'odom', in which the robot moves");
    // Also if it stands still.
    Recording still;
    for (int i = 0; i < 3; ++i) still.tf(i, "odom", "base_link", 7);
    still.cloud(1, "odom", "/registered");
    expectPart(still.error(), "in which the robot moves");
}

TEST(RosFrames, framesWithoutAWayAreNamed) {
    Recording r;
    r.fixed("base_link", "imu", 0);
    r.cloud(1, "lidar");
    expectPart(r.error(),
               "frame 'lidar', which has no transform to the robot's frame "
               "'base_link' (frames with transforms: 'base_link', 'imu')");
    Recording two;
    two.cloud(1, "front", "/a");
    two.cloud(1, "rear", "/b");
    expectPart(two.error(), "'/b' are in the frame 'rear'");
}

const char* const kNone = "no exception";  // see messageOf()

/// In metres along z, turned by the quaternion's z and w.
std::array<double, 7> above(double z, double qz = 0, double qw = 1) {
    return {0, 0, z, 0, 0, qz, qw};
}

/// A robot that drives in odom, its sensor at 'lidar', without the way there.
void addDrive(Recording& r, const std::string& scanFrame = "lidar") {
    for (int i = 0; i <= 4; ++i) {
        r.tf(i, "odom", "base_link", 0.5 * i);
        if (i > 0) r.cloud(i, scanFrame);
    }
}

TEST(RosFrames, staticTransformsThatDifferAreRefused) {
    Recording r;
    r.fixed("base_link", "lidar", 1);
    r.fixed("base_link", "lidar", 1);
    r.cloud(1, "lidar");
    EXPECT_EQ(r.robot().name, "base_link");
    r.fixed("base_link", "lidar", 2);
    expectPart(r.error(),
               "/tf_static tells that 'lidar' is in 'base_link' at (1, 0, 0) m, quaternion "
               "(0, 0, 0, 1), and at (2, 0, 0) m");
    expectPart(r.error(), "the sensor of '/points'");
    // Of no concern, if nothing is taken from there.
    Recording other;
    other.fixed("base_link", "imu", 1);
    other.fixed("base_link", "imu", 2);
    other.fixed("base_link", "lidar", 1);
    addDrive(other);
    EXPECT_EQ(other.build().scans, 4u);
}

TEST(RosFrames, staticTransformsOfOneRotationAreTheSame) {
    // As several publishers make them of one description.
    for (const auto& again :
         {above(1, -0.6, -0.8), above(1 + 1e-9, 0.6 + 1e-9, 0.8), above(1, 0.606, 0.808)}) {
        Recording r;
        r.tf(0, "base_link", "lidar", above(1, 0.6, 0.8), "/tf_static");
        r.tf(0, "base_link", "lidar", again, "/tf_static");
        addDrive(r);
        EXPECT_EQ(r.build().scans, 4u);
    }
    for (const auto& other : {above(1.0001, 0.6, 0.8), above(1, 0.6001, 0.7999)}) {
        Recording r;
        r.tf(0, "base_link", "lidar", above(1, 0.6, 0.8), "/tf_static");
        r.tf(0, "base_link", "lidar", other, "/tf_static");
        addDrive(r);
        expectPart(r.buildError(), "/tf_static tells that 'lidar'");
    }
}

TEST(RosFrames, posesThatNeedContradictedTransformsAreRefused) {
    Recording r;
    addDrive(r, "base_link");
    r.fixed("map", "odom", 0);
    const auto before = r.build();
    expectPart(before.poses, "robot poses 'tf map'");
    r.fixed("map", "odom", 100);
    const auto error = r.buildError();
    for (const char* part :
         {"'odom' is in 'map' at (0, 0, 0) m", "and at (100, 0, 0) m", "robot poses 'tf map'"})
        expectPart(error, part);
    // Not where other poses are taken.
    EXPECT_EQ(r.build(rosOptions("", "tf odom")).digest, before.digest);
    ScanSourceOptions fixed;
    fixed.poses = PoseOrigin::fixed;
    EXPECT_EQ(r.build(fixed).scans, 4u);

    Recording foot;
    for (int i = 0; i <= 4; ++i) {
        foot.odometry(i, "odom", "base_footprint", i);
        foot.cloud(i, "base_link");
    }
    foot.fixed("base_footprint", "base_link", 0.1);
    EXPECT_EQ(foot.build().scans, 5u);
    foot.fixed("base_footprint", "base_link", 5);
    expectPart(foot.buildError(), "'base_link' is in 'base_footprint' at (0.1, 0, 0) m");
    expectPart(foot.buildError(), "which of them holds for odometry '/odom'");
}

TEST(RosFrames, whatBothTopicsTellMustBeTheSame) {
    for (const bool staticIsFirst : {true, false})
        for (const double moving : {1, 2}) {
            Recording r;
            const auto fix = [&] { r.tf(0, "base_link", "lidar", above(1), "/tf_static"); };
            if (staticIsFirst) fix();
            for (int i = 0; i <= 4; ++i) r.tf(i, "base_link", "lidar", above(moving), "/tf");
            if (!staticIsFirst) fix();
            addDrive(r);
            if (moving == 1) {
                EXPECT_EQ(r.build().scans, 4u);
            } else {
                expectPart(r.buildError(),
                           "/tf_static tells that 'lidar' is in 'base_link' at (0, 0, 1) m, "
                           "quaternion (0, 0, 0, 1), and /tf at (0, 0, 2) m");
            }
        }
}

TEST(RosFrames, aSensorOfTwoParentsMustBeAtOnePlace) {
    const auto lidarAt = [](double x, const std::string& parent, const std::string& above) {
        Recording r;
        r.fixed("base_link", "lidar", 1);
        r.fixed(parent, "lidar", x);
        r.fixed(above, parent, 0.5);
        addDrive(r);
        return r.buildError();
    };
    expectPart(lidarAt(3, "imu", "base_link"),
               "'lidar' is in 'base_link' at (1, 0, 0) m, quaternion (0, 0, 0, 1) by way of "
               "'base_link', and at (3.5, 0, 0) m, quaternion (0, 0, 0, 1) by way of 'imu', "
               "'base_link'");
    EXPECT_EQ(lidarAt(0.5, "imu", "base_link"), kNone);
    EXPECT_EQ(lidarAt(0.5001, "imu", "base_link"), kNone);  // rounded
    // Not a way to the robot.
    EXPECT_EQ(lidarAt(3, "scanned", "map"), kNone);
    EXPECT_EQ(lidarAt(3, "odom", "map"), kNone);

    // The robot's frame has two parents, the sensor is above both.
    for (const double x : {-1.0, 4.0}) {
        Recording r;
        r.fixed("lidar", "base_link", -1);
        r.fixed("lidar", "mast", 0.5);
        r.fixed("mast", "base_link", x - 0.5);
        addDrive(r);
        const auto error = r.buildError();
        if (x == -1.0)
            EXPECT_EQ(error, kNone);
        else
            expectPart(error, "by way of 'mast', 'base_link'");
    }
}

TEST(RosFrames, aTurningSensorOfTwoParentsIsComparedWhereItScans) {
    for (const double off : {0.0, 1.0}) {
        Recording r;
        for (int i = 0; i <= 20; ++i) r.tf(0.2 * i, "base_link", "lidar", 1, 0.1 * i);
        r.fixed("base_link", "mast", 1);
        for (int i = 0; i <= 10; ++i) r.tf(0.4 * i, "mast", "lidar", off, 0.2 * i);
        addDrive(r);
        if (off == 0.0)
            EXPECT_EQ(r.build().scans, 4u);
        else
            expectPart(r.buildError(), "by way of 'mast', 'base_link'");
    }
}

TEST(RosFrames, posesInAFrameOfTheRobotAreNotItsOwn) {
    for (const char* frame : {"base_link", "camera", "/wrist"}) {
        Recording r;
        r.fixed("base_link", "camera", 1);
        for (int i = 0; i <= 4; ++i) r.tf(i, "camera", "wrist", 1);  // never changes
        for (int i = 0; i <= 4; ++i) {
            r.odometry(i, "odom", "base_link", i);
            r.cloud(i, "base_link");
        }
        const auto expected = r.build();
        for (int i = 0; i <= 4; ++i) r.poseStamped(i, frame, 3 - i, "/dock_pose");
        const auto built = r.build();
        EXPECT_EQ(built.digest, expected.digest) << frame;
        expectPart(built.poses, "odometry '/odom', 5");
        expectPart(built.poses, "without '/dock_pose', which is in the ");
        const auto asked = r.buildError(rosOptions("", "/dock_pose"));
        expectPart(asked, "'/dock_pose' (--pose-label) is in the ");
        expectPart(asked, "the recording has: odometry '/odom' (5)");
        expectPart(r.buildError(rosOptions("", "gps")), "without '/dock_pose'");
        ScanSourceOptions poses;
        poses.poses = PoseOrigin::robotPoses;
        expectPart(r.buildError(poses), "'/dock_pose' is in the ");
    }
    // Those in other frames are, also if nothing is told of these.
    for (const char* frame : {"map", ""}) {
        Recording r;
        for (int i = 0; i <= 4; ++i) {
            r.poseStamped(i, frame, i, "/mocap");
            r.cloud(i, "base_link");
        }
        expectPart(r.build().poses, "robot poses '/mocap', 5");
    }
}

TEST(RosFrames, aSensorWhoseTransformWasDroppedIsToldOf) {
    const std::array<double, 7> none{0, 0, 1, 0, 0, 0, 0};
    Recording r;
    r.tf(0, "base_link", "lidar", none, "/tf_static");
    addDrive(r);
    const auto error = r.buildError();
    expectPart(error,
               "whose transform to the robot's frame 'base_link' was dropped: of 'lidar' in "
               "'base_link', the quaternion (0, 0, 0, 0) is no rotation");
    // If it is the only one that names the robot's frame, too; and a link further up.
    Recording poses;
    poses.tf(0, "base_link", "mast", none, "/tf_static");
    poses.fixed("mast", "lidar", 1);
    for (int i = 0; i <= 4; ++i) {
        poses.poseStamped(i, "map", i, "/mocap");
        poses.cloud(i, "lidar");
    }
    expectPart(poses.buildError(), "was dropped: of 'mast' in 'base_link'");
    // Not if it was told rightly, too.
    r.fixed("base_link", "lidar", 1);
    EXPECT_EQ(r.build().scans, 4u);
}

TEST(RosFrames, theRobotIsTheChildOfTheOdometryWhereNoNameTells) {
    Recording r;
    r.fixed("body", "lidar", 1);
    r.odometry(1, "odom", "body", 5);
    r.cloud(1, "lidar");
    EXPECT_EQ(r.robot().name, "body");
    expectPoseNear(r.poses().odometry.at("/odom").entries.at(0).pose, ahead(5));
    // In a namespace.
    Recording named;
    named.fixed("husky/base_link", "lidar", 1);
    named.cloud(1, "lidar");
    EXPECT_EQ(named.robot().name, "husky/base_link");
}

TEST(RosFrames, odometryOfAnotherFrameIsBroughtToTheRobots) {
    Recording r;
    r.fixed("base_footprint", "base_link", 0.5);
    r.fixed("base_link", "lidar", 1);
    r.odometry(1, "odom", "base_footprint", 5);
    r.odometry(1, "odom", "elsewhere", 5, "/other");
    r.cloud(1, "lidar");
    const auto streams = r.poses().odometry;
    ASSERT_EQ(streams.size(), 1u);
    expectPoseNear(streams.at("/odom").entries.at(0).pose, ahead(5.5));
    const auto found = robotPoses(r.contents(), "base_link", Recording::limits());
    expectPart(found.unusable, "'/other' is of frame 'elsewhere'");
}

TEST(RosFrames, posesAreThoseOfTheRootAndOdometryThoseBetween) {
    Recording r;
    r.cloud(1, "base_link");
    for (int i = 0; i <= 20; ++i) r.tf(0.1 * i, "odom", "base_link", 0.1 * i);
    r.tf(0, "map", "odom", 10);
    r.tf(2, "map", "odom", 12);
    auto streams = r.poses();
    ASSERT_EQ(streams.robotPoses.size(), 1u);
    ASSERT_EQ(streams.odometry.size(), 1u);
    const auto& map = streams.robotPoses.at("tf map").entries;
    ASSERT_EQ(map.size(), 21u);
    expectPoseNear(map.at(10).pose, ahead(10 + 1 + 1), 1e-6);  // both links interpolated
    EXPECT_EQ(streams.odometry.count("tf odom"), 1u);
    // A topic in the same frame tells the same.
    r.odometry(1, "odom", "base_link", 1);
    streams = r.poses();
    EXPECT_EQ(streams.odometry.size(), 1u);
    EXPECT_EQ(streams.odometry.count("/odom"), 1u);
}

TEST(RosFrames, twoParentsAreTwoSources) {
    Recording r;
    r.cloud(1, "base_link");
    for (int i = 0; i < 3; ++i) {
        r.tf(i, "odom", "base_link", i);
        r.tf(i, "world", "base_link", i + 5);
    }
    const auto streams = r.poses();
    EXPECT_EQ(streams.robotPoses.size(), 2u);
    expectPoseNear(streams.robotPoses.at("tf world").entries.at(2).pose, ahead(7));
}

TEST(RosFrames, circlesAndDeepTreesEnd) {
    Recording r;
    r.tf(1, "a", "b", 1);
    r.tf(1, "b", "a", 1);
    r.cloud(1, "a");
    EXPECT_EQ(r.contents().frames().ancestors("a").size(), 2u);
    for (int i = 0; i < 1000; ++i)
        r.fixed("f" + std::to_string(i + 1), "f" + std::to_string(i), 1);
    EXPECT_EQ(r.contents().frames().ancestors("f0").size(), 101u);
}

TEST(RosFrames, transformsThatAreNoneAreCounted) {
    Recording r;
    Bytes bytes;
    bytes.add(std::uint32_t{1}).header(1, "odom").add("base_link").zeros(7);
    r.add("/tf", "tf2_msgs/TFMessage", bytes);
    r.tf(1, "odom", "base_link", std::numeric_limits<double>::quiet_NaN());
    EXPECT_EQ(r.contents().badPoses(), 2u);
    EXPECT_TRUE(r.contents().frames().empty());
}

TEST(RosFrames, messagesThatBreakTheRulesAreNamed) {
    Recording r;
    const auto error = [&](const char* type, const Bytes& bytes) {
        return messageOf<InputError>([&] { r.add("/t", type, bytes); });
    };
    Bytes many;
    many.add(std::numeric_limits<std::uint32_t>::max());
    expectPart(error("tf2_msgs/TFMessage", many), "message 1 (/t, tf2_msgs/TFMessage)");
    expectPart(error("tf2_msgs/TFMessage", many), "tells 4294967295 elements");
    Bytes longer;
    longer.header(1, "map").pose(0, 0).add('x');
    expectPart(error("geometry_msgs/PoseStamped", longer), "1 bytes follow");
    Bytes late;
    late.add(0u).add(1u).add(1000000000u).add("map").pose(0, 0);
    expectPart(error("geometry_msgs/PoseStamped", late), "1000000000 nanoseconds");
    r.odometry(1, "odom", "base_link", 0);
    expectPart(messageOf<InputError>([&] { r.odometry(1, "odom2", "base_link", 0); }),
               "the ones before of 'base_link' in 'odom'");
}

}  // namespace
}  // namespace superray
