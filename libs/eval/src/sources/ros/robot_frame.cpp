// SPDX-License-Identifier: BSD-3-Clause
#include "sources/ros/robot_frame.h"

#include <superray/eval/input_error.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace superray {
namespace {

bool isNamed(const std::string& frame, const std::string& name) {
    return frame == name ||
           (frame.size() > name.size() &&
            frame.compare(frame.size() - name.size() - 1, name.size() + 1, "/" + name) == 0);
}

/// Frames that the recording says are the robot, the likeliest first.
std::vector<std::string> toldCandidates(const RosContents& contents) {
    std::set<std::string> known;
    for (const std::string& frame : contents.frames().frames()) known.insert(frame);
    for (const auto& [topic, told] : contents.odometry())
        if (!told.child.empty()) known.insert(told.child);
    for (const auto& frame : contents.scanFrames()) known.insert(frame.first);
    std::vector<std::string> candidates;
    for (const char* name : {"base_link", "base_footprint"})
        for (const std::string& frame : known)
            if (isNamed(frame, name)) candidates.push_back(frame);
    for (const auto& [topic, told] : contents.odometry())
        if (!told.child.empty()) candidates.push_back(told.child);
    return candidates;
}

/// The highest frame that /tf_static tells of a scan's.
std::string topOfFixed(const RosContents& contents) {
    std::string top;
    for (const auto& ancestor :
         contents.frames().ancestors(contents.scanFrames().begin()->first))
        if (ancestor.chain.isFixed()) top = ancestor.frame;
    return top;
}

std::optional<RobotFrame> mountedOn(const std::string& frame, const RosContents& contents) {
    RobotFrame robot;
    robot.name = frame;
    for (const auto& [scanFrame, topic] : contents.scanFrames()) {
        auto path = contents.frames().path(scanFrame, frame);
        if (!path) return std::nullopt;
        robot.mounts.emplace(scanFrame, std::move(*path));
    }
    return robot;
}

[[noreturn]] void failUnmounted(const RosContents& contents, const std::string& robot,
                                const std::string& what) {
    std::string frame, topic;
    for (const auto& [scanFrame, scanTopic] : contents.scanFrames())
        if (frame.empty() && !contents.frames().path(scanFrame, robot)) {
            frame = scanFrame;
            topic = scanTopic;
        }
    const auto above = contents.frames().ancestors(robot);
    const bool robotMovesInIt =
        std::any_of(above.begin(), above.end(),
                    [&](const FrameTree::Ancestor& a) { return a.frame == frame; });
    constexpr std::size_t kListed = 20;
    std::string known;
    auto names = contents.frames().frames();
    const bool areMore = names.size() > kListed;
    if (areMore) names.resize(kListed);
    for (const std::string& name : names) known += (known.empty() ? "'" : ", '") + name + "'";
    if (areMore) known += ", and others";
    throw InputError(
        what + ": the scans of '" + topic + "' are in the frame '" + frame + "', " +
        (robotMovesInIt ? "in which the robot moves ('" + robot +
                              "'): they do not tell where the sensor was. Use another topic "
                              "(--sensor)"
                        : "which has no transform to the robot's frame '" + robot +
                              "' (frames with transforms: " + (known.empty() ? "none" : known) +
                              "). Record /tf_static with them, use other topics (--sensor), "
                              "or give the poses of '" +
                              frame + "' itself (--poses FILE)"));
}

void noteUnusable(const std::string& topic, const std::string& child, const std::string& robot,
                  std::string& to) {
    to += (to.empty() ? "'" : ", '") + topic + "' is of frame '" + child +
          "', which has no transform to '" + robot + "'";
}

[[noreturn]] void failContradicted(const std::string& what, const std::string& scanFrame,
                                   const std::string& robot) {
    throw InputError(what + ": /tf_static tells different transforms between '" + scanFrame +
                     "' and '" + robot + "': cut the recording where they change");
}

void addTopics(const std::map<std::string, TopicPoses>& topics, const FrameTree& frames,
               const std::string& robot, const PoseLimits& limits, PoseStreamsByLabel& to,
               std::string& unusable) {
    for (const auto& [topic, told] : topics) {
        std::optional<FramePath> path = FramePath{};
        if (!told.child.empty()) path = frames.path(robot, told.child);
        if (!path) {
            noteUnusable(topic, told.child, robot, unusable);
            continue;
        }
        PoseStream& stream = to[topic];
        for (const TransformSample& s : told.samples) {
            const Place place{s.time, s.order, s.order};
            const auto pose = s.pose.asPose();
            if (!pose) {
                ++stream.notFinite;
            } else if (const auto there = path->at(s.time, limits); there.pose) {
                stream.add(place, *pose + *there.pose);
            }
        }
    }
}

/// At the times of all moving links of a chain.
PoseStream streamOf(const FrameChain& chain, const PoseLimits& limits) {
    std::map<mrpt::Clock::time_point, std::uint64_t> times;
    for (const FrameLink* link : chain.links)
        for (const TransformSample& s : link->moving())
            if (s.time != mrpt::Clock::time_point()) times[s.time] = s.order;
    PoseStream stream;
    for (const auto& [time, order] : times)
        if (const auto there = chain.at(time, limits); there.pose)
            stream.add({time, order, order}, *there.pose);
    return stream;
}

}  // namespace

PoseAnswer RobotFrame::mountAt(const std::string& scanFrame, mrpt::Clock::time_point time,
                               const PoseLimits& limits) const {
    const auto found = mounts.find(scanFrame);
    return found == mounts.end() ? PoseAnswer{} : found->second.at(time, limits);
}

void mount(const RosScan& scan, const mrpt::poses::CPose3D& T_robot_frame) {
    mrpt::poses::CPose3D T_frame_sensor;
    scan.observation->getSensorPose(T_frame_sensor);
    scan.observation->setSensorPose(T_robot_frame + T_frame_sensor);
}

RobotFrame chooseRobotFrame(const RosContents& contents, const ScanSourceOptions& options,
                            const std::string& what) {
    std::vector<std::string> candidates = toldCandidates(contents);
    const bool isOwn = options.poses != PoseOrigin::file && options.poses != PoseOrigin::fixed;
    if (candidates.empty() || !isOwn) candidates.push_back(topOfFixed(contents));
    for (const std::string& frame : candidates) {
        const auto robot = mountedOn(frame, contents);
        if (!robot) continue;
        for (const auto& [scanFrame, path] : robot->mounts)
            if (path.up.isContradicted() || path.down.isContradicted())
                failContradicted(what, scanFrame, frame);
        return *robot;
    }
    failUnmounted(contents, candidates.front(), what);
}

RosPoses robotPoses(const RosContents& contents, const std::string& robotFrame,
                    const PoseLimits& limits) {
    RosPoses result;
    const FrameTree& frames = contents.frames();
    addTopics(contents.odometry(), frames, robotFrame, limits, result.streams.odometry,
              result.unusable);
    addTopics(contents.poses(), frames, robotFrame, limits, result.streams.robotPoses,
              result.unusable);
    for (const FrameTree::Ancestor& a : frames.ancestors(robotFrame)) {
        if (a.chain.isFixed()) continue;
        const bool isToldByTopic =
            std::any_of(contents.odometry().begin(), contents.odometry().end(),
                        [&](const auto& topic) { return topic.second.frame == a.frame; });
        if (!a.isRoot && isToldByTopic) continue;
        PoseStream stream = streamOf(a.chain, limits);
        if (stream.empty()) continue;
        auto& to = a.isRoot ? result.streams.robotPoses : result.streams.odometry;
        to["tf " + a.frame] = std::move(stream);
    }
    return result;
}

}  // namespace superray
