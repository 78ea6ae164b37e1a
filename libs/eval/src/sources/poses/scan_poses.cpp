// SPDX-License-Identifier: BSD-3-Clause
#include "sources/poses/scan_poses.h"

#include <superray/eval/input_error.h>
#include <superray/eval/trajectory.h>

#include <optional>
#include <utility>

namespace superray {
namespace {

using Time = PoseTrack::Time;

/// Odometry and scans are rarely logged at the same instant: how long before
/// the first or after the last pose a scan may be [s].
constexpr double kPoseSlack = 0.05;

class TimeSpan {
 public:
    void see(const Place& place) {
        if (!place.hasTime()) return;
        if (!first_ || place.time < *first_) first_ = place.time;
        if (!last_ || place.time > *last_) last_ = place.time;
    }
    void see(const std::vector<PoseEntry>& entries) {
        for (const PoseEntry& e : entries) see(e.place);
    }
    const std::optional<Time>& first() const { return first_; }
    const std::optional<Time>& last() const { return last_; }

 private:
    std::optional<Time> first_, last_;
};

/// All that a recording has a time of.
TimeSpan spanOf(const RecordedPoses& recorded) {
    TimeSpan span;
    for (const ScanPlace& s : recorded.scans) span.see(s.place);
    for (const auto* all : {&recorded.streams.robotPoses, &recorded.streams.odometry})
        for (const auto& labelled : *all) span.see(labelled.second.entries);
    span.see(recorded.streams.actions.entries);
    return span;
}

}  // namespace

PoseLimits poseLimits(const ScanSourceOptions& options) {
    PoseLimits limits;
    limits.maxGap = options.maxPoseGap;
    limits.slack = kPoseSlack;
    return limits;
}

ScanPoses::ScanPoses(const RecordedPoses& recorded, const ScanSourceOptions& options,
                     const std::string& what)
    : limits_(poseLimits(options)) {
    if (options.poses == PoseOrigin::fixed) {
        fixed_ = true;
        summary_.source = "the robot stays at the map's origin";
    } else if (options.poses == PoseOrigin::file) {
        useFile(recorded, options);
    } else {
        decide(recorded, options, what);
    }
}

void ScanPoses::useFile(const RecordedPoses& recorded, const ScanSourceOptions& options) {
    limits_.slack = 0;
    assigned_.byTime = true;
    const Trajectory poses = Trajectory::load(options.posesFile);
    notFinite_ = poses.skippedRows();
    assigned_.track = poses;
    const auto start = spanOf(recorded).first().value_or(assigned_.track.firstTime());
    summary_ = PoseSummary("file '" + options.posesFile + "'", assigned_.track.size());
    summary_.setTimes(secondsBetween(start, assigned_.track.firstTime()),
                      secondsBetween(start, assigned_.track.lastTime()));
}

void ScanPoses::use(const PoseCandidate& chosen, PoseAssignment assigned,
                    const RecordedPoses& recorded) {
    assigned_ = std::move(assigned);
    notFinite_ += chosen.stream->notFinite;
    summary_.source = chosen.name();
    summary_.count = chosen.stream->entries.size();
    TimeSpan span;
    span.see(chosen.stream->entries);
    if (span.first()) {
        const Time start = *spanOf(recorded).first();
        summary_.setTimes(secondsBetween(start, *span.first()),
                          secondsBetween(start, *span.last()));
    }
    if (!assigned_.byTime && chosen.kind != PoseOrigin::actions)
        summary_.note = "paired with the scans by their order";
}

void ScanPoses::decide(const RecordedPoses& recorded, const ScanSourceOptions& options,
                       const std::string& what) {
    const PoseChooser chooser(recorded.streams, options, what);
    const auto& scans = recorded.scans;
    const auto robotPoses = chooser.robotPoses();
    if (!robotPoses) {
        if (const auto motion = chooser.motion())
            use(*motion, assignPoses(*motion, scans, limits_, what), recorded);
        return;
    }
    PoseAssignment alone;
    std::optional<InputError> failure;
    try {
        alone = assignPoses(*robotPoses, scans, limits_, what);
    } catch (const InputError& e) {
        failure = e;
    }
    const auto posed = alone.count(scans, limits_);
    if (!failure && posed == scans.size()) return use(*robotPoses, alone, recorded);
    const auto motion = chooser.motion();
    if (!motion) {
        if (failure) throw InputError(*failure);
        return use(*robotPoses, alone, recorded);
    }
    std::size_t anchors = 0;
    auto anchored = assignAnchored(*robotPoses, *motion, scans, limits_, what, anchors);
    const std::string name = robotPoses->name() + ", ";
    if (anchored.count(scans, limits_) > posed) {
        use(*motion, std::move(anchored), recorded);
        summary_.note = "fixed to the map by " + name + std::to_string(anchors);
        notFinite_ += robotPoses->stream->notFinite;
    } else if (posed > 0) {
        use(*robotPoses, alone, recorded);
    } else {
        use(*motion, assignPoses(*motion, scans, limits_, what), recorded);
        summary_.note = name + std::to_string(robotPoses->stream->entries.size()) +
                        ", not used: at none of their times is a scan or a movement";
    }
}

PoseAnswer ScanPoses::at(const Place& scan) const {
    if (fixed_) return {PoseAnswer::Result::found, mrpt::poses::CPose3D()};
    return assigned_.at(scan, limits_);
}

}  // namespace superray
