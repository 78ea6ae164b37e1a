// SPDX-License-Identifier: BSD-3-Clause
#include "sources/ros/ros_contents.h"

#include <superray/eval/input_error.h>

#include <algorithm>
#include <array>

#include "sources/scan_source_formats.h"

namespace superray {
namespace {

struct Use {
    const char* type;
    RosUse use;
};

constexpr std::array<Use, 9> kUses{{
    {"tf2_msgs/TFMessage", RosUse::transforms},
    {"tf/tfMessage", RosUse::transforms},
    {"nav_msgs/Odometry", RosUse::odometry},
    {"geometry_msgs/PoseStamped", RosUse::poses},
    {"geometry_msgs/PoseWithCovarianceStamped", RosUse::posesWithCovariance},
    {"sensor_msgs/PointCloud2", RosUse::cloud},
    {"sensor_msgs/LaserScan", RosUse::laser},
    {"sensor_msgs/Image", RosUse::image},
    {"sensor_msgs/CameraInfo", RosUse::camera},
}};

bool endsWith(const std::string& text, const std::string& end) {
    return text.size() >= end.size() &&
           text.compare(text.size() - end.size(), end.size(), end) == 0;
}

MessageCursor cursorOf(const RosTopic& topic, std::string_view bytes) {
    return {bytes, topic.encoding == "cdr" ? Serialisation::cdr : Serialisation::ros1};
}

/// Calls `read`; its errors name the message.
template <class Read>
auto named(const RosRecording& recording, const RosTopic& topic, std::uint64_t order,
           const Read& read) -> decltype(read()) {
    try {
        return read();
    } catch (const MalformedBytes& e) {
        throw InputError(recording.path() + ": message " + std::to_string(order) + " (" +
                         topic.name + ", " + topic.type + ") cannot be used: " + e.what());
    }
}

}  // namespace

RosUse useOf(const RosTopic& topic) {
    if (topic.encoding != "ros1" && topic.encoding != "cdr") return RosUse::nothing;
    const auto* found = std::find_if(kUses.begin(), kUses.end(),
                                     [&](const Use& u) { return topic.type == u.type; });
    if (found == kUses.end()) return RosUse::nothing;
    const bool isGoal = topic.name.find("goal") != std::string::npos;
    if (found->use == RosUse::poses && isGoal) return RosUse::nothing;
    const bool isStatic = found->use == RosUse::transforms && endsWith(topic.name, "tf_static");
    return isStatic ? RosUse::fixedTransforms : found->use;
}

/// Equal transforms a second apart tell as much as all in between.
RosContents::RosContents(const ScanSourceOptions& options)
    : options_(options), frames_(std::min(1.0, options.maxPoseGap)) {}

void RosContents::add(const RosRecording& recording, const RosMessage& message) {
    ++messages_;
    const RosTopic& topic = recording.topics().at(message.topic);
    named(recording, topic, messages_, [&] {
        RosUse use = useOf(topic);
        const bool isScan =
            use == RosUse::cloud || use == RosUse::laser ||
            (use == RosUse::image && isDepthImage(cursorOf(topic, message.bytes)));
        if (isScan)
            addScan(topic, message.topic, message.bytes);
        else if (use == RosUse::nothing || use == RosUse::image)
            ++unused_[{topic.name, topic.type}];
        else
            take(topic, use, message.bytes);
    });
}

void RosContents::take(const RosTopic& topic, RosUse use, std::string_view bytes) {
    MessageCursor in = cursorOf(topic, bytes);
    if (use == RosUse::transforms || use == RosUse::fixedTransforms) {
        const auto kind =
            use == RosUse::transforms ? TransformTopic::moving : TransformTopic::fixed;
        for (const RosTransform& t : readTransforms(in))
            badPoses_ += !frames_.add(t, kind, messages_);
    } else if (use == RosUse::odometry) {
        addPose(odometry_, topic, readOdometry(in));
    } else if (use == RosUse::poses) {
        addPose(poses_, topic, readPoseStamped(in));
    } else if (use == RosUse::posesWithCovariance) {
        addPose(poses_, topic, readPoseWithCovariance(in));
    } else {
        const RosCamera camera = readCameraInfo(in);
        auto& known = cameras_[topic.name];
        if (known.empty() || !(known.back().second == camera))
            known.emplace_back(messages_, camera);
    }
}

void RosContents::addPose(std::map<std::string, TopicPoses>& to, const RosTopic& topic,
                          const RosTransform& pose) {
    TopicPoses& all = to[topic.name];
    if (all.samples.empty()) {
        all.frame = pose.header.frame;
        all.child = pose.child;
    } else if (all.frame != pose.header.frame || all.child != pose.child) {
        throw MalformedBytes("it is of '" + pose.child + "' in '" + pose.header.frame +
                             "', the ones before of '" + all.child + "' in '" + all.frame +
                             "'");
    }
    all.samples.push_back({pose.header.time, messages_, pose.pose});
}

void RosContents::addScan(const RosTopic& topic, std::size_t number, std::string_view bytes) {
    ++scanTopics_[topic.name];
    if (!acceptsLabel(options_, topic.name)) {
        ++skipped_.otherLabel;
        return;
    }
    MessageCursor in = cursorOf(topic, bytes);
    const RosHeader header = readHeader(in);
    scans_.push_back({{header.time, messages_, messages_}, static_cast<unsigned>(number)});
    frameOfScan_.push_back(&scanFrames_.emplace(header.frame, topic.name).first->first);
}

std::string RosContents::scanTopics() const {
    std::string text;
    for (const auto& [name, count] : scanTopics_)
        text += (text.empty() ? "'" : ", '") + name + "' (" + std::to_string(count) + ")";
    return text;
}

std::vector<std::string> RosContents::scanTopicNames() const {
    std::vector<std::string> names;
    for (const auto& entry : scanTopics_) names.push_back(entry.first);
    return names;
}

std::vector<RosTopicCount> RosContents::unusedTopics() const {
    std::vector<RosTopicCount> all;
    for (const auto& [name, count] : unused_) all.push_back({name.first, name.second, count});
    return all;
}

/// By ROS's rule: camera_info beside the image.
const RosCamera& RosContents::cameraOf(const std::string& imageTopic,
                                       std::uint64_t order) const {
    const std::string name = imageTopic.substr(0, imageTopic.rfind('/') + 1) + "camera_info";
    const auto found = cameras_.find(name);
    if (found == cameras_.end())
        throw MalformedBytes("there is no sensor_msgs/CameraInfo on '" + name +
                             "': record it with the images, or leave them out (--sensor)");
    const auto& known = found->second;
    const auto after =
        std::upper_bound(known.begin(), known.end(), order,
                         [](std::uint64_t o, const std::pair<std::uint64_t, RosCamera>& entry) {
                             return o < entry.first;
                         });
    return after == known.begin() ? after->second : std::prev(after)->second;
}

std::optional<RosScan> RosContents::readScan(const RosRecording& recording,
                                             const RosMessage& message,
                                             std::uint64_t order) const {
    const RosTopic& topic = recording.topics().at(message.topic);
    return named(recording, topic, order, [&]() -> std::optional<RosScan> {
        const RosUse use = useOf(topic);
        if (use != RosUse::cloud && use != RosUse::laser && use != RosUse::image)
            return std::nullopt;
        MessageCursor in = cursorOf(topic, message.bytes);
        if (use == RosUse::image && !isDepthImage(in)) return std::nullopt;
        const auto done = topic.name.find("rect") != std::string::npos ? Rectification::done
                                                                       : Rectification::none;
        RosScan scan = use == RosUse::cloud ? readPointCloud2(in)
                       : use == RosUse::laser
                           ? readLaserScan(in)
                           : readDepthImage(in, cameraOf(topic.name, order), done);
        scan.observation->sensorLabel = topic.name;
        return scan;
    });
}

}  // namespace superray
