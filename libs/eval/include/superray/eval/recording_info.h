// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file recording_info.h
/// What a recording holds, and what a build would make of it.

#include <superray/eval/scan_source.h>

#include <cstdint>
#include <string>
#include <vector>

namespace superray {

/// All observations of one label and class.
struct SensorInfo {
    std::string label, className;
    std::uint64_t count = 0;
    std::uint64_t withoutTime = 0;
    bool timed = false;          ///< whether first and last are known
    double first = 0, last = 0;  ///< [s] after the first time stamp of the recording

    bool isRangeSensor = false;  ///< one that a build uses; what follows is of such only
    std::uint64_t sampled = 0;   ///< scans that were read for the following
    std::uint64_t points = 0, noReturns = 0;  ///< sums over the sampled scans
    double nearest = 0, farthest = 0;         ///< [m] of their points
    bool planar = false;
    double tilt = 0;  ///< [degrees] of the sensor's z axis against the robot's, if planar
    std::uint64_t externalFiles = 0, externalMissing = 0;
    std::string missingFile;  ///< the first of those that are not there
    std::string unreadable;   ///< why the first scan that was not usable is not

    /// [Hz], by the time stamps; 0 if they do not tell.
    double rate() const { return last > first ? double(count - 1) / (last - first) : 0; }
};

/// A topic that no map can be made of.
struct UnusedTopic {
    std::string name, type;
    std::uint64_t count = 0;  ///< messages
};

struct RecordingInfo {
    std::string path, format;
    std::vector<SensorInfo> sensors;
    std::string posesFound;                 ///< all that there are, by kind and label
    std::vector<UnusedTopic> unusedTopics;  ///< of ROS recordings
    std::uint64_t actions = 0, emptyActions = 0;
    std::vector<std::string> externalFolders;  ///< looked in, if there are external files
    std::string damage;                        ///< why the end cannot be read; else empty

    // What a build with these options would do.
    bool canBuild = false;
    std::string problem;  ///< if it cannot: its error
    std::string poses;    ///< if it can: see PoseSummary
    std::uint64_t scans = 0;
    SkippedObservations skipped;
};

/// Reads a recording once, or twice. Files that end early are told of, not refused.
/// \throws InputError if there is nothing at the path, or of no known format
RecordingInfo inspectRecording(const std::string& path, const ScanSourceOptions& options = {});

/// Lines of text.
std::string describe(const RecordingInfo& info);

/// One JSON object: `file`, `format`, `sensors` [{label, class, count, first, last, rate,
/// ...}], `poses`, `unused_topics` [{topic, type, count}], `external_folders`, `damage`,
/// `build` {possible, problem, poses, scans, left_out}.
std::string describeAsJson(const RecordingInfo& info);

}  // namespace superray
