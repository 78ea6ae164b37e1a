// SPDX-License-Identifier: BSD-3-Clause
// Recordings of ROS 1 and 2, written by other programs (tests/data/formats), against the same
// scans in a rawlog; and what is told of those that lack something.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>
#include <superray/eval/recording_info.h>

#include <cstring>
#include <filesystem>

#include "eval/sources/ros_samples.h"

namespace superray {
namespace {

namespace fs = std::filesystem;
using namespace test;

std::string errorOf(const std::string& path, const ScanSourceOptions& options = {}) {
    return messageOf<InputError>([&] { build(path, options); });
}

TEST(RosFormats, bagsOfEveryCompressionGiveTheMapOfTheRawlog) {
    const auto expected = expectedRosDigest(rosCloud);
    for (const char* name : {"tf_none", "tf_bz2", "tf_lz4"}) {
        const auto built = build(sample(std::string("ros1/") + name + ".bag"));
        EXPECT_EQ(built.digest, expected) << name;
        EXPECT_EQ(built.scans, 3u);
        EXPECT_EQ(built.poses,
                  "robot poses 'tf map', 3, 0.0 to 1.0 s, of the frame 'base_link'");
    }
    // By their contents, too.
    TempFolder folder;
    const auto bag = folder.write("a", readWholeFile(sample("ros1/tf_none.bag")));
    EXPECT_EQ(build(bag).digest, expected);
}

TEST(RosFormats, bigEndianPaddedAndDoubleCloudsAreTheSame) {
    const auto built = build(sample("ros1/layouts.bag"));
    EXPECT_EQ(built.digest, expectedRosDigest(rosCloud));
    expectPart(built.poses, "odometry '/odom', 3, 0.0 to 1.0 s, of the frame 'base_link'");
}

TEST(RosFormats, coordinatesOfACountryAreRefused) {
    auto bag = readWholeFile(sample("ros1/layouts.bag"));
    // The second point of the last scan, whose coordinates are doubles.
    const double first = (37 + 2 * 11 - 100) / 16.0, far = 431234.56;
    const auto at = bag.find(std::string(reinterpret_cast<const char*>(&first), sizeof first));
    ASSERT_NE(at, std::string::npos);
    std::memcpy(&bag[at], &far, sizeof far);
    TempFolder folder;
    const auto error = errorOf(folder.write("far.bag", bag));
    expectPart(error, "has points at x 431234.56 m: coordinates of a country");
    expectPart(error, "sensor_msgs/PointCloud2");
}

TEST(RosFormats, posesOfTwoSourcesAreRefusedUntilOneIsChosen) {
    const auto bag = sample("ros1/two_odometries.bag");
    const auto error = errorOf(bag);
    expectPart(error, "odometry of 2 labels, '/visual' (3), '/wheels' (3)");
    expectPart(error, "choose one (--pose-label)");
    const auto expected = expectedRosDigest(rosCloud);
    EXPECT_EQ(build(bag, rosOptions("", "/wheels")).digest, expected);
    EXPECT_NE(build(bag, rosOptions("", "/visual")).digest, expected);
    const auto all = sample("ros2/little.db3");
    expectPart(errorOf(all), "'/amcl_pose' (3), '/mocap' (3), 'tf map' (3)");
    expectPart(errorOf(all, rosOptions("", "gps")), "has no poses with the label 'gps'");
}

TEST(RosFormats, everySourceOfPosesIsRead) {
    const auto expected = expectedRosDigest(rosCloud);
    for (const char* name : {"little.db3", "big.db3", "plain.mcap"})
        for (const char* label : {"tf map", "/amcl_pose", "/mocap", "/wheels"}) {
            const auto built =
                build(sample(std::string("ros2/") + name), rosOptions("/points", label));
            EXPECT_EQ(built.digest, expected) << name << " " << label;
            expectPart(built.poses, std::string("'") + label + "', 3, 0.0 to 1.0 s");
        }
    ScanSourceOptions odometry = rosOptions("/points");
    odometry.poses = PoseOrigin::odometry;
    EXPECT_EQ(build(sample("ros2/little.db3"), odometry).digest, expected);
}

TEST(RosFormats, ros2OfEveryStorageGivesTheMapOfTheRawlog) {
    const auto clouds = expectedRosDigest(rosCloud), lasers = expectedRosDigest(rosLaser),
               images = expectedRosDigest(rosImage);
    for (const char* name : {"little.db3", "big.db3", "plain.mcap", "unchunked.mcap",
                             "lz4.mcap", "zstd.mcap", "split"}) {
        const auto path = sample(std::string("ros2/") + name);
        const auto digestOf = [&](const char* sensor) {
            return build(path, rosOptions(sensor, "tf map")).digest;
        };
        EXPECT_EQ(digestOf("/points"), clouds) << name;
        EXPECT_EQ(digestOf("/scan"), lasers) << name;
        EXPECT_EQ(digestOf("/depth/image_rect_raw"), images) << name;
    }
    const auto error = errorOf(sample("ros2/split"), rosOptions("/camera", "tf map"));
    expectPart(error, "'/depth/image_rect_raw' (3), '/points' (3), '/scan' (3)");
}

TEST(RosFormats, laserAndDepthOfRos1GiveTheMapOfTheRawlog) {
    const auto laser = build(sample("ros1/laser.bag"));
    EXPECT_EQ(laser.digest, expectedRosDigest(rosLaser));
    expectPart(laser.poses, "robot poses '/amcl_pose', 3");  // goals are no poses
    const auto images = build(sample("ros1/depth_16UC1.bag"));
    EXPECT_EQ(images.digest, expectedRosDigest(rosImage));
    expectPart(images.poses, "robot poses '/mocap', 3");
    EXPECT_EQ(build(sample("ros1/depth_32FC1.bag")).digest, expectedRosDigest(rosDepthPoints));
}

TEST(RosFormats, framesWithoutATransformAreNamedWithTheWayOut) {
    const auto bag = sample("ros1/no_tf.bag");
    const auto error = errorOf(bag);
    for (const char* part : {"'/points'", "frame 'lidar'", "no transform",
                             "robot's frame 'base_link'", "/tf_static", "--poses FILE"})
        expectPart(error, part);
    // Poses of the sensor itself.
    const auto built = build(bag, withPoses(sample("poses.tum")));
    EXPECT_EQ(built.digest, expectedDigest());
    expectPart(built.poses, "of the frame 'lidar'");
    ScanSourceOptions fixed;
    fixed.poses = PoseOrigin::fixed;
    EXPECT_EQ(build(bag, fixed).scans, 3u);
}

TEST(RosFormats, aRecordingThatWasKilledIsReadAsFarAsItGoes) {
    const auto bag = sample("ros1/killed.bag.active");
    const auto error = errorOf(bag);
    expectPart(error, "'rosbag reindex' mends that");
    expectPart(error, "scans before it: 3 (--accept-truncated takes those)");
    ScanSourceOptions accept;
    accept.truncation = Truncation::accept;
    const auto built = build(bag, accept);
    EXPECT_EQ(built.digest, expectedRosDigest(rosCloud));
    // Folders whose recording was killed have no metadata.
    TempFolder folder;
    fs::copy(sample("ros2/split"), folder / "split");
    fs::remove(folder / "split/metadata.yaml");
    accept.sensorLabel = "/points";
    accept.poseLabel = "tf map";
    expectPart(errorOf(folder / "split", rosOptions("/points", "tf map")), "ros2 bag reindex");
    EXPECT_EQ(build(folder / "split", accept).digest, built.digest);
}

TEST(RosFormats, foldersMustHoldWhatTheyTell) {
    TempFolder folder;
    fs::copy(sample("ros2/split"), folder / "a");
    const auto metadata = readWholeFile(folder / "a/metadata.yaml");
    const auto replaced = [&](const std::string& from, const std::string& to) {
        std::string text = metadata;
        text.replace(text.find(from), from.size(), to);
        folder.write("a/metadata.yaml", text);
        return errorOf(folder / "a", rosOptions("/points", "tf map"));
    };
    expectPart(replaced("message_count: 28", "message_count: 29"), "tells 29");
    expectPart(replaced("compression_mode: \"\"", "compression_mode: FILE"), "compressed");
    expectPart(replaced("relative_file_paths", "other_paths"), "lists no files");
    fs::remove(folder / "a/split_1.db3");
    expectPart(replaced("version: 5", "version: 6"), "'split_1.db3', which is not there");
}

TEST(RosFormats, leftoversOfSqliteAreNotMissed) {
    TempFolder folder;
    const auto bag = folder.write("a.db3", readWholeFile(sample("ros2/little.db3")));
    folder.write("a.db3-wal", "x");
    expectPart(errorOf(bag, rosOptions("/points", "tf map")), "a recording that was not ended");
}

TEST(RosFormats, inspectShowsTopicsPosesAndWhatIsNotUsed) {
    const auto info = inspectRecording(sample("ros2/zstd.mcap"), rosOptions("", "tf map"));
    EXPECT_EQ(info.format, "MCAP (ROS)");
    ASSERT_EQ(info.sensors.size(), 3u);
    EXPECT_EQ(info.sensors[1].label, "/points");
    EXPECT_EQ(info.sensors[1].count, 3u);
    EXPECT_EQ(info.sensors[1].points, 180u);
    EXPECT_EQ(info.posesFound,
              "robot poses '/amcl_pose' (3), '/mocap' (3), 'tf map' (3); "
              "odometry '/wheels' (3)");
    ASSERT_EQ(info.unusedTopics.size(), 1u);
    EXPECT_EQ(info.unusedTopics[0].name, "/chatter");
    EXPECT_EQ(info.unusedTopics[0].count, 3u);
    EXPECT_TRUE(info.canBuild);
    EXPECT_EQ(info.scans, 9u);
    expectPart(describe(info), "not used    '/chatter' std_msgs/String: 3");
    expectPart(describeAsJson(info), "\"topic\": \"/chatter\"");
    const auto killed = inspectRecording(sample("ros1/killed.bag.active"));
    EXPECT_FALSE(killed.canBuild);
    expectPart(killed.damage, "rosbag reindex");
    EXPECT_EQ(killed.sensors.size(), 1u);
}

}  // namespace
}  // namespace superray
