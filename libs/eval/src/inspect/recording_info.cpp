// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <superray/eval/input_error.h>
#include <superray/eval/recording_info.h>

#include "inspect/sensor_survey.h"
#include "sources/object_reader.h"
#include "sources/poses/pose_chooser.h"
#include "sources/poses/scan_poses.h"
#include "sources/ros/robot_frame.h"
#include "sources/scan_source_formats.h"

namespace superray {
namespace {

using mrpt::obs::CObservation;
using mrpt::serialization::CSerializable;

void surveyObject(const CSerializable::Ptr& object, SensorSurvey& sensors, PoseStreams& poses) {
    const auto see = [&](const CObservation& o) {
        sensors.add(o);
        poses.add(o, {o.timestamp});
    };
    if (const auto observation = std::dynamic_pointer_cast<CObservation>(object)) {
        see(*observation);
    } else if (const auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object)) {
        for (const auto& part : *frame) see(*part);
    } else if (const auto actions =
                   std::dynamic_pointer_cast<mrpt::obs::CActionCollection>(object)) {
        mrpt::poses::CPose3D increment;
        if (actions->getFirstMovementEstimationMean(increment))
            poses.addAction(increment, {});
        else
            ++poses.emptyActions;
    }
}

void surveyRawlog(const std::string& path, RecordingInfo& info) {
    SensorSurvey sensors(path);
    PoseStreams poses;
    try {
        ObjectReader reader(path);
        while (const auto object = reader.next()) surveyObject(object, sensors, poses);
    } catch (const InputError& e) {
        info.damage = e.what();
    }
    info.sensors = sensors.result();
    info.posesFound = PoseChooser::list(poses);
    info.actions = poses.actions.entries.size() + poses.emptyActions;
    info.emptyActions = poses.emptyActions;
    for (const SensorInfo& s : info.sensors)
        if (s.externalFiles > 0 && info.externalFolders.empty())
            for (const auto& folder : sensors.folders().folders())
                info.externalFolders.push_back(folder.string());
}

/// The scans of a recording that was read once, until it ends or cannot be read on.
void surveyRosScans(const RosContents& contents, const RobotFrame& robot,
                    const PoseLimits& limits, RosRecording& recording, SensorSurvey& sensors) {
    while (recording.messages() < contents.messages()) {
        const auto message = recording.next();
        if (!message) return;
        const auto scan = contents.readScan(recording, *message, recording.messages());
        if (!scan) continue;
        const auto mounted = robot.mountAt(scan->frame, scan->observation->timestamp, limits);
        if (mounted.pose) mount(*scan, *mounted.pose);
        sensors.add(*scan->observation);
    }
}

void surveyRos(const std::string& path, const ScanSourceOptions& asked, RecordingInfo& info) {
    ScanSourceOptions options = asked;
    options.sensorLabel.clear();
    const PoseLimits limits = poseLimits(options);
    RosContents contents(options);
    SensorSurvey sensors(path);
    try {
        const auto recording = openRosRecording(path);
        while (const auto message = recording->next()) contents.add(*recording, *message);
    } catch (const InputError& e) {
        info.damage = e.what();
    }
    for (const RosTopicCount& t : contents.unusedTopics())
        info.unusedTopics.push_back({t.name, t.type, t.messages});
    if (contents.scans().empty()) return;
    RobotFrame robot;
    try {
        robot = chooseRobotFrame(contents, options, path);
        info.posesFound = PoseChooser::list(robotPoses(contents, robot.name, limits).streams);
    } catch (const InputError&) {
        // What a build says of it, too.
    }
    try {
        surveyRosScans(contents, robot, limits, *openRosRecording(path), sensors);
    } catch (const InputError& e) {
        if (info.damage.empty()) info.damage = e.what();
    }
    info.sensors = sensors.result();
}

/// Formats that hold scans only: by way of their own reader.
void surveyScans(const std::string& path, const ScanSourceOptions& asked, RecordingInfo& info) {
    ScanSourceOptions options = asked;
    options.sensorLabel.clear();
    if (options.poses != PoseOrigin::file) options.poses = PoseOrigin::fixed;
    options.truncation = Truncation::accept;
    SensorSurvey sensors(path);
    try {
        const auto source = openScanSource(path, options);
        info.damage = source->warning();
        while (const auto scan = source->next()) sensors.add(*scan->observation);
    } catch (const InputError& e) {
        info.damage = e.what();
    }
    info.sensors = sensors.result();
}

void tryBuild(const std::string& path, const ScanSourceOptions& options, RecordingInfo& info) {
    try {
        const auto source = openScanSource(path, options);
        checkSensorLabels(options.sensorLabel, source->sensorLabels());
        info.scans = source->total();
        info.poses = source->poses().asText();
        while (source->next()) {
        }
        info.skipped = source->skipped();
        info.canBuild = true;
    } catch (const InputError& e) {
        info.problem = e.what();
    }
}

}  // namespace

RecordingInfo inspectRecording(const std::string& path, const ScanSourceOptions& options) {
    RecordingInfo info;
    info.path = path;
    info.format = recordingFormat(path);
    if (info.format == kRawlogFormat)
        surveyRawlog(path, info);
    else if (isRosFormat(info.format))
        surveyRos(path, options, info);
    else
        surveyScans(path, options, info);
    if (info.sensors.empty() && !info.damage.empty()) throw InputError(info.damage);
    tryBuild(path, options, info);
    return info;
}

}  // namespace superray
