// SPDX-License-Identifier: BSD-3-Clause
#include "sources/poses/pose_contradiction.h"

#include <mrpt/math/CQuaternion.h>
#include <superray/core/cell.h>
#include <superray/eval/input_error.h>
#include <superray/maps/option_text.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace superray {
namespace {

using mrpt::poses::CPose3D;
using PosesByTime = std::map<mrpt::Clock::time_point, std::vector<CPose3D>>;

struct Way {
    double metres = 0, radians = 0;
};

Way between(const CPose3D& a, const CPose3D& b) {
    const CPose3D difference = b - a;
    mrpt::math::CQuaternionDouble q;
    difference.getAsQuaternion(q);
    return {difference.norm(), 2 * std::acos(std::min(1.0, std::abs(q.r())))};
}

/// The shortest way, and the smallest turn, from a pose of one time to one of another.
Way leastBetween(const std::vector<CPose3D>& from, const std::vector<CPose3D>& to) {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    Way least{kNone, kNone};
    for (const CPose3D& a : from)
        for (const CPose3D& b : to) {
            const Way way = between(a, b);
            least.metres = std::min(least.metres, way.metres);
            least.radians = std::min(least.radians, way.radians);
        }
    return least;
}

/// What the robot may have moved around the time of an entry.
Way wayAround(const PosesByTime& all, PosesByTime::const_iterator at) {
    const bool first = at == all.begin(), last = std::next(at) == all.end();
    if (first && last) return {};
    return leastBetween(first ? at->second : std::prev(at)->second,
                        last ? at->second : std::next(at)->second);
}

}  // namespace

bool mostTimesDiffer(const PoseStream& stream) {
    constexpr std::size_t kSeveral = 3;
    std::set<mrpt::Clock::time_point> times;
    for (const PoseEntry& e : stream.entries)
        if (e.place.hasTime()) times.insert(e.place.time);
    return times.size() >= kSeveral && 2 * times.size() >= stream.entries.size();
}

void requireOnePoseATime(const PoseStream& stream, const std::string& what) {
    constexpr double kDistance = 0.1, kTurn = 0.1;  // [m], [rad]
    PosesByTime all;
    for (const PoseEntry& e : stream.entries)
        if (e.place.hasTime()) all[e.place.time].push_back(e.pose);
    for (auto at = all.begin(); at != all.end(); ++at) {
        const auto& poses = at->second;
        for (std::size_t i = 1; i < poses.size(); ++i) {
            const Way apart = between(poses[i - 1], poses[i]);
            if (apart.metres <= kDistance && apart.radians <= kTurn) continue;
            const Way around = wayAround(all, at);
            if (apart.metres <= std::max(kDistance, 2 * around.metres) &&
                apart.radians <= std::max(kTurn, 2 * around.radians))
                continue;
            throw InputError(what + ": two poses of the time " +
                             std::to_string(mrpt::Clock::toDouble(at->first)) +
                             " s contradict each other: they are " + metresText(apart.metres) +
                             " and " + formatValue(apart.radians) +
                             " rad apart; give a poses file (--poses FILE), or choose other "
                             "poses");
        }
    }
}

}  // namespace superray
