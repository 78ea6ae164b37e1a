// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/progress_meter.h>
#include <superray/eval/recording_info.h>
#include <superray/maps/option_text.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "text/text_table.h"

namespace superray {
namespace {

std::string sensorDetails(const SensorInfo& s) {
    std::string text;
    const auto add = [&](const std::string& part) {
        text += (text.empty() ? "" : ", ") + part;
    };
    if (s.sampled > 0) {
        add((s.planar ? "planar, " : "") + formatCount(s.points / s.sampled) +
            " points a scan");
        if (s.points > 0)
            add("ranges " + formatShort(s.nearest) + " to " + formatShort(s.farthest) + " m");
        if (s.planar && s.tilt > 0.05) add("tilted " + formatFixed(s.tilt, 1) + " degrees");
        if (s.noReturns > 0) add(formatCount(s.noReturns / s.sampled) + " without return");
        if (s.sampled < s.count) add("by " + std::to_string(s.sampled) + " scans");
    }
    if (s.externalFiles > 0)
        add("external files: " + formatCount(s.externalFiles - s.externalMissing) + " of " +
            formatCount(s.externalFiles) + " found");
    if (!s.missingFile.empty()) add("missing: " + s.missingFile);
    if (!s.unreadable.empty()) add("NOT USABLE: " + s.unreadable);
    return text;
}

void addLeftOut(const SkippedObservations& skipped, std::ostream& out) {
    const auto add = [&](std::uint64_t number, const char* what) {
        if (number > 0) out << "left out    " << formatCount(number) << " " << what << "\n";
    };
    add(skipped.otherLabel, "scans of another sensor");
    add(skipped.withoutPose, "scans outside the time of the poses");
    add(skipped.inPoseGap, "scans in a gap between two poses");
    add(skipped.withoutTime, "scans without a time stamp");
    add(skipped.badPoses, "poses that are not finite");
}

}  // namespace

std::string describe(const RecordingInfo& info) {
    std::ostringstream out;
    out << "file        " << info.path << "\nformat      " << info.format << "\n";
    for (const SensorInfo& s : info.sensors) {
        out << "sensor      '" << printable(s.label) << "' " << s.className << ": "
            << formatCount(s.count);
        if (s.timed)
            out << ", " << formatFixed(s.first, 1) << " to " << formatFixed(s.last, 1) << " s";
        if (s.rate() > 0) out << ", " << formatShort(s.rate()) << " Hz";
        if (s.withoutTime > 0) out << ", " << formatCount(s.withoutTime) << " without a time";
        out << "\n";
        const std::string details = sensorDetails(s);
        if (!details.empty()) out << "            " << details << "\n";
    }
    if (info.actions > 0)
        out << "actions     " << formatCount(info.actions) << ", of which "
            << formatCount(info.emptyActions) << " tell no movement\n";
    if (!info.posesFound.empty()) out << "has poses   " << printable(info.posesFound) << "\n";
    for (const UnusedTopic& t : info.unusedTopics)
        out << "not used    '" << printable(t.name) << "' " << printable(t.type) << ": "
            << formatCount(t.count) << "\n";
    if (!info.externalFolders.empty()) {
        out << "looked in   ";
        for (std::size_t i = 0; i < info.externalFolders.size(); ++i)
            out << (i > 0 ? ", " : "") << info.externalFolders[i];
        out << "\n";
    }
    if (!info.damage.empty()) out << "damage      " << info.damage << "\n";
    if (!info.canBuild) {
        out << "build       not possible: " << info.problem << "\n";
        return out.str();
    }
    out << "build       " << formatCount(info.scans) << " scans\n"
        << "poses: " << info.poses << "\n";
    addLeftOut(info.skipped, out);
    return out.str();
}

std::string describeAsJson(const RecordingInfo& info) {
    using Json = nlohmann::ordered_json;
    Json sensors = Json::array();
    for (const SensorInfo& s : info.sensors) {
        Json sensor{{"label", s.label},
                    {"class", s.className},
                    {"count", s.count},
                    {"first", s.timed ? Json(s.first) : Json()},
                    {"last", s.timed ? Json(s.last) : Json()},
                    {"rate", s.rate() > 0 ? Json(s.rate()) : Json()},
                    {"without_time", s.withoutTime},
                    {"range_sensor", s.isRangeSensor}};
        if (s.isRangeSensor) {
            sensor["sampled_scans"] = s.sampled;
            sensor["points"] = s.points;
            sensor["without_return"] = s.noReturns;
            sensor["ranges"] = s.points > 0 ? Json{s.nearest, s.farthest} : Json();
            sensor["planar"] = s.planar;
            sensor["tilt"] = s.tilt;
            sensor["external_files"] = s.externalFiles;
            sensor["external_missing"] = s.externalMissing;
            sensor["unusable"] = s.unreadable.empty() ? Json() : Json(s.unreadable);
        }
        sensors.push_back(sensor);
    }
    Json unused = Json::array();
    for (const UnusedTopic& t : info.unusedTopics)
        unused.push_back({{"topic", t.name}, {"type", t.type}, {"count", t.count}});
    const Json build{{"possible", info.canBuild},
                     {"problem", info.canBuild ? Json() : Json(info.problem)},
                     {"poses", info.canBuild ? Json(info.poses) : Json()},
                     {"scans", info.scans},
                     {"left_out",
                      {{"other_sensor", info.skipped.otherLabel},
                       {"outside_poses", info.skipped.withoutPose},
                       {"in_pose_gap", info.skipped.inPoseGap},
                       {"without_time", info.skipped.withoutTime},
                       {"poses_not_finite", info.skipped.badPoses}}}};
    const Json json{{"file", info.path},
                    {"format", info.format},
                    {"sensors", sensors},
                    {"poses", info.posesFound},
                    {"unused_topics", unused},
                    {"actions", {{"count", info.actions}, {"empty", info.emptyActions}}},
                    {"external_folders", info.externalFolders},
                    {"damage", info.damage.empty() ? Json() : Json(info.damage)},
                    {"build", build}};
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace superray
