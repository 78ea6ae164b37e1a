// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file ros_contents.h
/// What a first pass over a ROS recording learns, and how its scans are read.

#include <superray/eval/scan_source.h>

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sources/poses/pose_assignment.h"
#include "sources/ros/frame_tree.h"
#include "sources/ros/ros_recording.h"
#include "sources/ros/ros_scans.h"

namespace superray {

/// What a topic is used for.
enum class RosUse : std::uint8_t {
    nothing,
    transforms,
    fixedTransforms,
    odometry,
    poses,
    posesWithCovariance,
    cloud,
    laser,
    image,  ///< a scan, if it is of depths
    camera
};

/// By type and name: PoseStamped topics with "goal" in their name are no poses of a robot.
RosUse useOf(const RosTopic& topic);

/// How many messages a topic has.
struct RosTopicCount {
    std::string name, type;
    std::uint64_t messages = 0;
};

/// Poses that one topic tells.
struct TopicPoses {
    std::string frame, child;  ///< the same in all its messages; child: empty if not told
    std::vector<TransformSample> samples;
};

class RosContents {
 public:
    explicit RosContents(const ScanSourceOptions& options);
    RosContents(const RosContents&) = delete;
    RosContents& operator=(const RosContents&) = delete;

    /// Reads what is needed of the next message. \throws InputError, naming topic and message
    void add(const RosRecording& recording, const RosMessage& message);

    /// Messages so far. Their numbers are the orders of poses and scans, from 1.
    std::uint64_t messages() const { return messages_; }

    const FrameTree& frames() const { return frames_; }
    const std::map<std::string, TopicPoses>& odometry() const { return odometry_; }
    const std::map<std::string, TopicPoses>& poses() const { return poses_; }

    /// Scans of topics that the options ask for.
    const std::vector<ScanPlace>& scans() const { return scans_; }
    /// The frame of each of them.
    const std::vector<const std::string*>& frameOfScan() const { return frameOfScan_; }
    /// Names of the frames in which they are, each with its first topic.
    const std::map<std::string, std::string>& scanFrames() const { return scanFrames_; }
    /// "'/scan' (20), '/points' (10)": topics of range sensors.
    std::string scanTopics() const;
    std::vector<std::string> scanTopicNames() const;

    const SkippedObservations& skipped() const { return skipped_; }
    /// Transforms and poses that were dropped.
    std::uint64_t badPoses() const { return badPoses_; }
    /// Topics that are of no use here.
    std::vector<RosTopicCount> unusedTopics() const;

    /// The message as a scan, its label that of the topic; nullopt if it is none.
    /// \param order number of the message \throws InputError, naming topic and message
    std::optional<RosScan> readScan(const RosRecording& recording, const RosMessage& message,
                                    std::uint64_t order) const;

 private:
    void take(const RosTopic& topic, RosUse use, std::string_view bytes);
    void addPose(std::map<std::string, TopicPoses>& to, const RosTopic& topic,
                 const RosTransform& pose);
    void addScan(const RosTopic& topic, std::size_t number, std::string_view bytes);
    const RosCamera& cameraOf(const std::string& imageTopic, std::uint64_t order) const;

    ScanSourceOptions options_;
    std::uint64_t messages_ = 0, badPoses_ = 0;
    FrameTree frames_;
    std::map<std::string, TopicPoses> odometry_, poses_;
    std::vector<ScanPlace> scans_;
    std::vector<const std::string*> frameOfScan_;  // keys of scanFrames_
    std::map<std::string, std::string> scanFrames_;
    std::map<std::string, std::uint64_t> scanTopics_;
    std::map<std::pair<std::string, std::string>, std::uint64_t> unused_;  // by name, type
    /// Of each topic, from which message on.
    std::map<std::string, std::vector<std::pair<std::uint64_t, RosCamera>>> cameras_;
    SkippedObservations skipped_;
};

}  // namespace superray
