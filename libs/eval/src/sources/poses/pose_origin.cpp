// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/pose_origin.h>

#include <array>
#include <cstdio>
#include <stdexcept>

namespace superray {
namespace {

struct Name {
    PoseOrigin origin;
    const char* name;
};

constexpr std::array<Name, 7> kNames{{{PoseOrigin::input, "auto"},
                                      {PoseOrigin::file, "file"},
                                      {PoseOrigin::fixed, "fixed"},
                                      {PoseOrigin::robotPoses, "poses"},
                                      {PoseOrigin::odometry, "odometry"},
                                      {PoseOrigin::actions, "actions"},
                                      {PoseOrigin::motion, "motion"}}};

}  // namespace

const char* toString(PoseOrigin origin) {
    for (const Name& n : kNames)
        if (n.origin == origin) return n.name;
    return "";
}

PoseOrigin poseOriginFromString(const std::string& name) {
    std::string known;
    for (const Name& n : kNames) {
        if (name == n.name) return n.origin;
        known += (known.empty() ? "" : ", ") + std::string(n.name);
    }
    throw std::invalid_argument("source of poses '" + name + "': must be one of " + known);
}

std::string PoseSummary::asText() const {
    std::string text = source;
    if (count > 0) text += ", " + std::to_string(count);
    if (timed) {
        char times[80];
        std::snprintf(times, sizeof times, ", %.1f to %.1f s", first, last);
        text += times;
    }
    if (!note.empty()) text += ", " + note;
    return text;
}

}  // namespace superray
