// SPDX-License-Identifier: BSD-3-Clause
#include "inspect/sensor_survey.h"

#include <superray/eval/input_error.h>
#include <superray/maps/observation_rays.h>
#include <superray/maps/pose_track.h>

#include <algorithm>
#include <cmath>

#include "sources/scan_source_formats.h"

namespace superray {

void SensorSurvey::add(const mrpt::obs::CObservation& observation) {
    std::string className = observation.GetRuntimeClass()->className;
    const auto colons = className.rfind("::");
    if (colons != std::string::npos) className.erase(0, colons + 2);
    Entry& entry = sensors_[{observation.sensorLabel, className}];
    SensorInfo& info = entry.info;
    if (++info.count == 1) {
        info.label = observation.sensorLabel;
        info.className = className;
        info.isRangeSensor = isRangeObservation(observation);
    }
    const auto time = observation.timestamp;
    if (time == mrpt::Clock::time_point()) {
        ++info.withoutTime;
    } else {
        entry.first = entry.first ? std::min(*entry.first, time) : time;
        entry.last = entry.last ? std::max(*entry.last, time) : time;
    }
    if (!info.isRangeSensor) return;
    const auto missing = info.externalMissing;
    addExternalFiles(observation, info);
    if (info.externalMissing == missing && info.sampled < kSampled)
        addReturns(observation, info);
}

void SensorSurvey::addExternalFiles(const mrpt::obs::CObservation& observation,
                                    SensorInfo& info) const {
    for (const std::string& file : externalFilesOf(observation)) {
        ++info.externalFiles;
        if (!folders_.find(file).empty()) continue;
        ++info.externalMissing;
        if (info.missingFile.empty()) info.missingFile = file;
    }
}

void SensorSurvey::addReturns(const mrpt::obs::CObservation& observation,
                              SensorInfo& info) const {
    std::optional<SensorReturns> returns;
    try {
        folders_.useFor(observation);
        returns = readReturns(observation, {});
    } catch (const std::exception& e) {
        if (info.unreadable.empty()) info.unreadable = oneLineCause(e);
        return;
    }
    if (!returns) {
        if (info.unreadable.empty()) info.unreadable = whyUnreadable(observation);
        if (info.unreadable.empty()) info.unreadable = "it has no ranges and no points";
        return;
    }
    info.planar = returns->planar;
    const double upright = std::abs(returns->sensorOnRobot.getRotationMatrix()(2, 2));
    info.tilt = std::max(info.tilt, std::acos(std::min(upright, 1.0)) * 180 / M_PI);
    ++info.sampled;
    info.noReturns += returns->noReturnCount;
    for (const Eigen::Vector3f& p : returns->hits) {
        const double range = static_cast<double>(p.norm());
        if (!std::isfinite(range)) continue;
        info.nearest = info.points == 0 ? range : std::min(info.nearest, range);
        info.farthest = std::max(info.farthest, range);
        ++info.points;
    }
}

std::vector<SensorInfo> SensorSurvey::result() const {
    std::optional<mrpt::Clock::time_point> start;
    for (const auto& [name, entry] : sensors_)
        if (entry.first) start = start ? std::min(*start, *entry.first) : *entry.first;
    std::vector<SensorInfo> result;
    for (const auto& [name, entry] : sensors_) {
        result.push_back(entry.info);
        SensorInfo& info = result.back();
        info.timed = entry.first.has_value();
        if (!info.timed) continue;
        info.first = secondsBetween(*start, *entry.first);
        info.last = secondsBetween(*start, *entry.last);
    }
    return result;
}

}  // namespace superray
