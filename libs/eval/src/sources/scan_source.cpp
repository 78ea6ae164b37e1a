// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <superray/eval/input_error.h>
#include <superray/maps/option_text.h>
#include <superray/maps/options.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <set>

#include "sources/object_reader.h"
#include "sources/scan_source_formats.h"

namespace superray {
namespace {

std::string asSeconds(Trajectory::Time time) {
    char text[40];
    std::snprintf(text, sizeof text, "%.3f", mrpt::Clock::toDouble(time));
    return text;
}

}  // namespace

bool isRangeObservation(const mrpt::obs::CObservation& observation) {
    using namespace mrpt::obs;
    return IS_CLASS(observation, CObservation2DRangeScan) ||
           IS_CLASS(observation, CObservation3DRangeScan) ||
           IS_CLASS(observation, CObservationVelodyneScan) ||
           IS_CLASS(observation, CObservationPointCloud) ||
           IS_CLASS(observation, CObservationRotatingScan);
}

bool acceptsLabel(const ScanSourceOptions& options, const std::string& label) {
    TInsertionOptions filter;
    filter.sensorLabel = options.sensorLabel;
    return filter.acceptsSensor(label);
}

bool hasWantedLabel(const mrpt::obs::CObservation& observation,
                    const ScanSourceOptions& options, SkippedObservations& skipped) {
    if (acceptsLabel(options, observation.sensorLabel)) return true;
    ++skipped.otherLabel;
    return false;
}

void checkSensorLabels(const std::string& asked, const std::vector<std::string>& labels) {
    for (const std::string& label : splitList(asked)) {
        if (std::find(labels.begin(), labels.end(), label) != labels.end()) continue;
        std::string known;
        for (const std::string& k : std::set<std::string>(labels.begin(), labels.end()))
            known += (known.empty() ? "'" : ", '") + k + "'";
        throw InputError("sensor label '" + shortened(label) +
                         "': no scan has it; the labels are " + known);
    }
}

PoseLookup::PoseLookup(const ScanSourceOptions& options)
    : origin_(options.poses), file_(options.posesFile) {
    limits_.maxGap = options.maxPoseGap;
    if (origin_ == PoseOrigin::file) trajectory_ = Trajectory::load(file_);
}

PoseAnswer PoseLookup::pose(Trajectory::Time time,
                            const std::optional<mrpt::poses::CPose3D>& fromInput) const {
    if (origin_ == PoseOrigin::file) return trajectory_.lookUp(time, limits_);
    if (origin_ == PoseOrigin::fixed)
        return {PoseAnswer::Result::found, mrpt::poses::CPose3D()};
    if (fromInput) return {PoseAnswer::Result::found, fromInput};
    return {};
}

PoseSummary PoseLookup::summary(Trajectory::Time firstScan,
                                const PoseSummary& fromInput) const {
    PoseSummary summary = fromInput;
    if (origin_ == PoseOrigin::fixed)
        summary = PoseSummary("the robot stays at the map's origin");
    if (origin_ == PoseOrigin::file) {
        const auto after = [&](Trajectory::Time time) {
            return secondsBetween(firstScan, time);
        };
        summary = PoseSummary("file '" + file_ + "'", trajectory_.size());
        summary.setTimes(after(trajectory_.firstTime()), after(trajectory_.lastTime()));
    }
    return summary;
}

std::string acceptBreak(const InputError& error, std::uint64_t scans,
                        const ScanSourceOptions& options) {
    std::string message =
        std::string(error.what()) + "; scans before it: " + std::to_string(scans);
    const bool isTruncated = dynamic_cast<const TruncatedInputError*>(&error) != nullptr;
    if (isTruncated && options.truncation == Truncation::error)
        throw InputError(message + " (--accept-truncated takes those)");
    if (!isTruncated && options.truncation == Truncation::accept)
        throw InputError(message + "; it is damaged, not truncated: nothing of it is certain");
    if (!isTruncated || scans == 0) throw InputError(message);
    return message;
}

void countWithoutPose(const PoseAnswer& answer, SkippedObservations& skipped) {
    ++(answer.result == PoseAnswer::Result::inGap ? skipped.inPoseGap : skipped.withoutPose);
}

void throwNoScanHasPose(const std::string& path, const ScanSourceOptions& options,
                        Trajectory::Time firstScan, Trajectory::Time lastScan,
                        const PoseTrack* poses) {
    const bool asked = options.poses != PoseOrigin::input || !options.poseLabel.empty();
    if (poses == nullptr || poses->empty())
        throw InputError(
            path +
            ": holds no robot poses (CObservationRobotPose, actions or "
            "odometry) " +
            (asked ? "of the kind and label that were asked for" : "that can be used") +
            "; give a poses file (--poses FILE), or say that the"
            " robot did not move (--fixed-robot)");
    const bool ofFile = options.poses == PoseOrigin::file;
    const bool overlap = firstScan <= poses->lastTime() && lastScan >= poses->firstTime();
    char gap[40];
    std::snprintf(gap, sizeof gap, "%g", options.maxPoseGap);
    throw InputError(
        (ofFile ? options.posesFile : path) + ": no pose is at the time of a scan: poses " +
        asSeconds(poses->firstTime()) + " to " + asSeconds(poses->lastTime()) +
        " s, scans of " + path + " " + asSeconds(firstScan) + " to " + asSeconds(lastScan) +
        " s" +
        (overlap
             ? std::string("; gaps of more than ") + gap + " s are not bridged (--max-pose-gap)"
         : ofFile ? "; where the clocks differ, put the poses on the scans' clock, or give "
                    "folders poses without times, in 12 columns"
                  : ""));
}

void throwNoScans(const std::string& path, const ScanSourceOptions& options,
                  const SkippedObservations& skipped, const std::string& labels) {
    if (skipped.otherLabel > 0)
        throw InputError(path + ": none of its " + std::to_string(skipped.otherLabel) +
                         " scans has the sensor label '" + options.sensorLabel + "'" +
                         (labels.empty() ? "" : "; its labels are " + labels));
    throw InputError(path +
                     ": holds no scans (laser, depth, Velodyne or point-cloud "
                     "observations)");
}

}  // namespace superray
