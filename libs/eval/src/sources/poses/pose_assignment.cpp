// SPDX-License-Identifier: BSD-3-Clause
#include "sources/poses/pose_assignment.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>

#include "sources/poses/anchored_motion.h"
#include "sources/poses/order_pairing.h"
#include "sources/poses/pose_contradiction.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;
using Time = PoseTrack::Time;

/// False if no time is known, or most are the same.
bool stampsTell(const std::vector<Place>& places) {
    std::set<Time> times;
    for (const Place& p : places)
        if (p.hasTime()) times.insert(p.time);
    return places.size() == 1 ? !times.empty() : 2 * times.size() > places.size();
}

bool stampsTell(const PoseStream& stream) {
    std::vector<Place> places;
    for (const PoseEntry& e : stream.entries) places.push_back(e.place);
    return stampsTell(places);
}

/// Those of the sensor with the most scans.
bool stampsTell(const std::vector<ScanPlace>& scans) {
    std::map<unsigned, std::vector<Place>> bySensor;
    for (const ScanPlace& s : scans) bySensor[s.sensor].push_back(s.place);
    const auto most = std::max_element(
        bySensor.begin(), bySensor.end(),
        [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    return most == bySensor.end() || stampsTell(most->second);
}

/// Whether time stamps tell which pose belongs to which scan. One pose with a time can
/// only belong to the scans of its time.
bool timesTell(const PoseCandidate& chosen, const std::vector<ScanPlace>& scans) {
    if (chosen.kind == PoseOrigin::actions || !stampsTell(*chosen.stream)) return false;
    const bool anyTime = std::any_of(scans.begin(), scans.end(),
                                     [](const ScanPlace& s) { return s.place.hasTime(); });
    return chosen.stream->entries.size() == 1 ? anyTime : stampsTell(scans);
}

/// The last pose before a place in the recording; nullptr if there is none.
const PoseEntry* entryBefore(const PoseStream& poses, std::uint64_t order) {
    const auto after =
        std::upper_bound(poses.entries.begin(), poses.entries.end(), order,
                         [](std::uint64_t o, const PoseEntry& e) { return o < e.place.order; });
    return after == poses.entries.begin() ? nullptr : &*std::prev(after);
}

CPose3D lastBefore(const PoseStream& poses, std::uint64_t order, const CPose3D& start) {
    const PoseEntry* entry = entryBefore(poses, order);
    return entry ? entry->pose : start;
}

/// Each scan has the pose after the action before it. Where both have times, and the scan is
/// later by more than is bridged, the robot may have been anywhere.
void assignActions(const PoseStream& actions, const std::vector<ScanPlace>& scans,
                   const PoseLimits& limits, PoseAssignment& to) {
    const bool timed = stampsTell(actions) && stampsTell(scans);
    for (const ScanPlace& s : scans) {
        const PoseEntry* action = entryBefore(actions, s.place.order);
        const bool tellsTime = timed && action && action->place.hasTime() && s.place.hasTime();
        if (tellsTime && secondsBetween(action->place.time, s.place.time) > limits.maxGap)
            continue;
        to.byOrder[s.place.order] = action ? action->pose : CPose3D();
    }
}

void assignByOrder(const std::vector<PoseEntry>& poses, const std::vector<ScanPlace>& scans,
                   const std::string& what, PoseAssignment& to) {
    for (const auto& [order, index] : pairByOrder(poses, scans, what))
        to.byOrder[order] = poses[index].pose;
}

/// Several different poses of one time belong to the scans of that time by their order.
void assignEqualTimes(const PoseStream& stream, const std::vector<ScanPlace>& scans,
                      const std::string& what, PoseAssignment& to) {
    std::map<Time, std::vector<PoseEntry>> posesAt;
    for (const PoseEntry& e : stream.entries)
        if (e.place.hasTime()) posesAt[e.place.time].push_back(e);
    std::map<Time, std::vector<ScanPlace>> scansAt;
    for (const ScanPlace& s : scans) scansAt[s.place.time].push_back(s);
    for (const auto& [time, poses] : posesAt) {
        const auto scansThen = scansAt.find(time);
        const auto first = poses.front().pose.asTPose();
        const bool differ = std::any_of(poses.begin(), poses.end(), [&](const PoseEntry& e) {
            return e.pose.asTPose() != first;
        });
        if (differ && scansThen != scansAt.end())
            assignByOrder(poses, scansThen->second, what, to);
    }
}

/// Robot poses with the motion at their time.
AnchoredMotion anchorsByTime(const PoseStream& robotPoses, const PoseTrack& motion,
                             const PoseLimits& limits, PoseTrack& used) {
    AnchoredMotion anchored;
    PoseTrack sorted;
    for (const PoseEntry& e : robotPoses.entries)
        if (e.place.hasTime()) sorted.add(e.place.time, e.pose);
    // Before and after the odometry the robot is taken to stand, for as long as poses are
    // bridged: a start pose is often logged before the first odometry.
    PoseLimits atEnds = limits;
    atEnds.slack = limits.maxGap;
    for (const auto& [time, pose] : sorted.poses()) {
        auto there = motion.lookUp(time, limits);
        if (there.result == PoseAnswer::Result::outside) there = motion.lookUp(time, atEnds);
        if (!there.pose) continue;
        anchored.addAnchor(secondsBetween(motion.firstTime(), time), pose, *there.pose);
        used.add(time, pose);
    }
    return anchored;
}

PoseAssignment anchorInTime(const PoseCandidate& anchors, const PoseCandidate& motion,
                            const PoseLimits& limits, const std::string& what,
                            std::size_t& anchorsUsed) {
    requireOnePoseATime(*anchors.stream, what + ": " + anchors.name());
    requireOnePoseATime(*motion.stream, what + ": " + motion.name());
    PoseTrack odometry;
    for (const PoseEntry& e : motion.stream->entries)
        if (e.place.hasTime()) odometry.add(e.place.time, e.pose);
    PoseAssignment result;
    result.byTime = true;
    const AnchoredMotion anchored =
        anchorsByTime(*anchors.stream, odometry, limits, result.track);
    anchorsUsed = anchored.anchors();
    if (anchorsUsed == 0) return result;
    for (const auto& [time, pose] : odometry.poses())
        if (result.track.poses().count(time) == 0)
            result.track.add(time,
                             anchored.pose(secondsBetween(odometry.firstTime(), time), pose));
    return result;
}

PoseAssignment anchorInOrder(const PoseCandidate& anchors, const PoseCandidate& motion,
                             const std::vector<ScanPlace>& scans, const PoseLimits& limits,
                             const std::string& what, std::size_t& anchorsUsed) {
    // Before the first odometry the robot is taken to stand.
    const CPose3D start =
        motion.kind == PoseOrigin::actions ? CPose3D() : motion.stream->entries.front().pose;
    AnchoredMotion anchored;
    for (const PoseEntry& e : anchors.stream->entries)
        anchored.addAnchor(static_cast<double>(e.place.order), e.pose,
                           lastBefore(*motion.stream, e.place.order, start));
    anchorsUsed = anchored.anchors();
    PoseAssignment own = assignPoses(motion, scans, limits, what);
    PoseAssignment result;
    for (const auto& [order, pose] : own.byOrder)
        result.byOrder[order] = anchored.pose(static_cast<double>(order), pose);
    return result;
}

}  // namespace

PoseAnswer PoseAssignment::at(const Place& scan, const PoseLimits& limits) const {
    const auto found = byOrder.find(scan.order);
    if (found != byOrder.end()) return {PoseAnswer::Result::found, found->second};
    if (!byTime || !scan.hasTime()) return {};
    return track.lookUp(scan.time, limits);
}

std::uint64_t PoseAssignment::count(const std::vector<ScanPlace>& scans,
                                    const PoseLimits& limits) const {
    return static_cast<std::uint64_t>(std::count_if(
        scans.begin(), scans.end(),
        [&](const ScanPlace& s) { return at(s.place, limits).pose.has_value(); }));
}

PoseAssignment assignPoses(const PoseCandidate& chosen, const std::vector<ScanPlace>& scans,
                           const PoseLimits& limits, const std::string& what) {
    PoseAssignment result;
    if (chosen.kind == PoseOrigin::actions) {
        assignActions(*chosen.stream, scans, limits, result);
        return result;
    }
    // Where most times are the same, they tell nothing.
    if (mostTimesDiffer(*chosen.stream))
        requireOnePoseATime(*chosen.stream, what + ": " + chosen.name());
    if (timesTell(chosen, scans)) {
        result.byTime = true;
        for (const PoseEntry& e : chosen.stream->entries)
            if (e.place.hasTime()) result.track.add(e.place.time, e.pose);
        assignEqualTimes(*chosen.stream, scans, what + ": " + chosen.name(), result);
    } else {
        assignByOrder(chosen.stream->entries, scans, what + ": " + chosen.name(), result);
    }
    return result;
}

PoseAssignment assignAnchored(const PoseCandidate& anchors, const PoseCandidate& motion,
                              const std::vector<ScanPlace>& scans, const PoseLimits& limits,
                              const std::string& what, std::size_t& anchorsUsed) {
    anchorsUsed = 0;
    return timesTell(motion, scans)
               ? anchorInTime(anchors, motion, limits, what, anchorsUsed)
               : anchorInOrder(anchors, motion, scans, limits, what, anchorsUsed);
}

}  // namespace superray
