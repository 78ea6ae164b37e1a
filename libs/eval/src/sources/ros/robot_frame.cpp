// SPDX-License-Identifier: BSD-3-Clause
#include "sources/ros/robot_frame.h"

#include <superray/eval/input_error.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "sources/poses/scan_poses.h"

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
    for (const DroppedTransform& t : contents.frames().dropped()) {
        known.insert(t.child);
        known.insert(t.parent);
    }
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

/// The frame itself, and all above it.
std::set<std::string> namesAbove(const FrameTree& frames, const std::string& frame) {
    std::set<std::string> names;
    for (const FrameTree::Ancestor& a : frames.ancestors(frame)) names.insert(a.frame);
    return names;
}

std::string listFrames(const FrameTree& frames) {
    constexpr std::size_t kListed = 20;
    std::string known;
    auto names = frames.frames();
    const bool areMore = names.size() > kListed;
    if (areMore) names.resize(kListed);
    for (const std::string& name : names) known += (known.empty() ? "'" : ", '") + name + "'";
    if (areMore) known += ", and others";
    return known.empty() ? "none" : known;
}

/// The transform that would have been a frame's way to the robot, had it not been dropped.
std::optional<DroppedTransform> droppedBetween(const FrameTree& frames,
                                               const std::string& frame,
                                               const std::string& robot) {
    const auto aboveIt = namesAbove(frames, frame);
    std::set<std::string> aboveRobot;  // as far as /tf_static tells: see FrameTree::path()
    for (const FrameTree::Ancestor& a : frames.ancestors(robot))
        if (a.chain.isFixed()) aboveRobot.insert(a.frame);
    for (const DroppedTransform& t : frames.dropped()) {
        const bool isUpwards = aboveIt.count(t.child) > 0 && aboveRobot.count(t.parent) > 0;
        const bool isDownwards = aboveRobot.count(t.child) > 0 && aboveIt.count(t.parent) > 0;
        if (isUpwards || isDownwards) return t;
    }
    return std::nullopt;
}

[[noreturn]] void failUnmounted(const RosContents& contents, const std::string& robot,
                                const std::string& what) {
    const FrameTree& frames = contents.frames();
    std::string frame, topic;
    for (const auto& [scanFrame, scanTopic] : contents.scanFrames())
        if (frame.empty() && !frames.path(scanFrame, robot)) {
            frame = scanFrame;
            topic = scanTopic;
        }
    std::string why;
    if (namesAbove(frames, robot).count(frame) > 0) {
        why = "in which the robot moves ('" + robot +
              "'): they do not tell where the sensor was. Use another topic (--sensor)";
    } else if (const auto dropped = droppedBetween(frames, frame, robot)) {
        why = "whose transform to the robot's frame '" + robot + "' was dropped: of '" +
              dropped->child + "' in '" + dropped->parent + "', " + dropped->why +
              ". Record it as it should be, use other topics (--sensor), or give the poses "
              "of '" +
              frame + "' itself (--poses FILE)";
    } else {
        why = "which has no transform to the robot's frame '" + robot +
              "' (frames with transforms: " + listFrames(frames) +
              "). Record /tf_static with them, use other topics (--sensor), or give the "
              "poses of '" +
              frame + "' itself (--poses FILE)";
    }
    throw InputError(what + ": the scans of '" + topic + "' are in the frame '" + frame +
                     "', " + why);
}

void noteUnusable(const std::string& topic, const std::string& child, const std::string& robot,
                  std::string& to) {
    to += (to.empty() ? "'" : ", '") + topic + "' is of frame '" + child +
          "', which has no transform to '" + robot + "'";
}

/// Two ways whose links are rounded, or interpolated between other times, may differ by
/// that [m, rad].
constexpr double kSameFixedWay = 1e-3, kSameMovingWay = 1e-2;

std::string differing(const std::string& from, const std::string& to, const RosPose& here,
                      const FramePath& path, const RosPose& there, const FramePath& other) {
    return "'" + from + "' is in '" + to + "' at " + here.asText() + " by way of " +
           path.asText() + ", and at " + there.asText() + " by way of " + other.asText();
}

/// What the transforms of a path say twice, in words, or another way that says something
/// else at one of these times; empty: nothing.
std::string contradictionOf(const FramePath& path, const std::string& from,
                            const std::string& to, const FrameTree& frames,
                            const std::vector<mrpt::Clock::time_point>& times,
                            const PoseLimits& limits) {
    std::string told = path.contradiction();
    if (!told.empty()) return told;
    for (const FramePath& other : frames.pathsByParents(from, to)) {
        const bool isFixed = path.neverChanges() && other.neverChanges();
        for (const auto& time : times) {
            const auto one = path.at(time, limits), two = other.at(time, limits);
            if (!one.pose || !two.pose) continue;
            const RosPose here = rosPoseOf(*one.pose), there = rosPoseOf(*two.pose);
            if (!areSame(here, there, isFixed ? kSameFixedWay : kSameMovingWay))
                return differing(from, to, here, path, there, other);
            if (isFixed) break;
        }
    }
    return "";
}

[[noreturn]] void failContradicted(const std::string& what, const std::string& told,
                                   const std::string& topic) {
    throw InputError(what + ": " + told + ": where the sensor of '" + topic +
                     "' is on the robot, is not known. Cut the recording where that "
                     "changes, leave out the wrong one, or use other topics (--sensor)");
}

void checkMounts(const RobotFrame& robot, const RosContents& contents, const PoseLimits& limits,
                 const std::string& what) {
    std::map<std::string, std::vector<mrpt::Clock::time_point>> times;
    for (std::size_t i = 0; i < contents.scans().size(); ++i)
        times[*contents.frameOfScan()[i]].push_back(contents.scans()[i].place.time);
    for (const auto& [frame, path] : robot.mounts) {
        const auto told =
            contradictionOf(path, frame, robot.name, contents.frames(), times[frame], limits);
        if (told.empty()) continue;
        failContradicted(what, told, contents.scanFrames().at(frame));
    }
}

/// Topics of odometry, and of poses that are in no frame of the robot itself.
void addTopics(const std::map<std::string, TopicPoses>& topics, const FrameTree& frames,
               const std::string& robot, const PoseLimits& limits, PoseStreamsByLabel& to,
               RosPoses& result) {
    for (const auto& [topic, told] : topics) {
        if (result.notOfRobot.count(topic) > 0) continue;
        std::optional<FramePath> path = FramePath{};
        if (!told.child.empty()) path = frames.path(robot, told.child);
        if (!path) {
            noteUnusable(topic, told.child, robot, result.unusable);
            continue;
        }
        PoseStream& stream = to[topic];
        std::vector<mrpt::Clock::time_point> times;
        for (const TransformSample& s : told.samples) {
            const Place place{s.time, s.order, s.order};
            const auto pose = s.pose.asPose();
            times.push_back(s.time);
            if (!pose) {
                ++stream.notFinite;
            } else if (const auto there = path->at(s.time, limits); there.pose) {
                stream.add(place, *pose + *there.pose);
            }
        }
        if (told.child.empty()) continue;
        const auto twice = contradictionOf(*path, robot, told.child, frames, times, limits);
        if (!twice.empty()) result.contradictions[topic] = twice;
    }
}

/// Poses in the robot's own frame, or in one that is fixed to it, are of what it sees.
void findNotOfRobot(const RosContents& contents, const std::string& robot, RosPoses& result) {
    for (const auto& [topic, told] : contents.poses()) {
        if (told.frame.empty()) continue;  // not told
        const auto path = contents.frames().path(told.frame, robot);
        if (!path || !path->neverChanges()) continue;
        const std::string why =
            told.frame == robot
                ? "is in the robot's own frame '" + robot + "'"
                : "is in the frame '" + told.frame + "', which is fixed to the robot's";
        result.notOfRobot[topic] = why;
        result.unusable += result.unusable.empty() ? "'" : ", '";
        result.unusable.append(topic).append("' ").append(why);
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
        checkMounts(*robot, contents, poseLimits(options), what);
        return *robot;
    }
    failUnmounted(contents, candidates.front(), what);
}

RosPoses robotPoses(const RosContents& contents, const std::string& robotFrame,
                    const PoseLimits& limits) {
    RosPoses result;
    const FrameTree& frames = contents.frames();
    addTopics(contents.odometry(), frames, robotFrame, limits, result.streams.odometry, result);
    findNotOfRobot(contents, robotFrame, result);
    addTopics(contents.poses(), frames, robotFrame, limits, result.streams.robotPoses, result);
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
        const auto twice = a.chain.contradiction();
        if (!twice.empty()) result.contradictions["tf " + a.frame] = twice;
    }
    return result;
}

}  // namespace superray
