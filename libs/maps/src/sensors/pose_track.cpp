// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/math/CQuaternion.h>
#include <mrpt/math/slerp.h>
#include <superray/maps/pose_track.h>

#include <algorithm>
#include <chrono>
#include <iterator>

namespace superray {

using mrpt::poses::CPose3D;

namespace {

PoseAnswer found(const CPose3D& pose) {
    return {PoseAnswer::Result::found, pose};
}

}  // namespace

CPose3D interpolatePose(const CPose3D& a, const CPose3D& b, double fraction) {
    mrpt::math::CQuaternionDouble qa, qb, q;
    a.getAsQuaternion(qa);
    b.getAsQuaternion(qb);
    mrpt::math::slerp(qa, qb, fraction, q);
    q.normalize();
    const auto between = [fraction](double from, double to) {
        return from + fraction * (to - from);
    };
    return CPose3D(q, between(a.x(), b.x()), between(a.y(), b.y()), between(a.z(), b.z()));
}

PoseAnswer poseBetween(const TimedPose* before, const TimedPose* after,
                       mrpt::Clock::time_point time, const PoseLimits& limits) {
    using Result = PoseAnswer::Result;
    constexpr double kSameTime = 1e-6;  // s
    const double slack = std::max(limits.slack, kSameTime);
    const double untilAfter = after ? secondsBetween(time, after->first) : 0;
    const double sinceBefore = before ? secondsBetween(before->first, time) : 0;
    if (after && untilAfter <= kSameTime) return found(after->second);
    if (!after && before && sinceBefore <= slack) return found(before->second);
    if (!before && after && untilAfter <= slack) return found(after->second);
    if (!before || !after) return {};
    if (sinceBefore <= kSameTime) return found(before->second);
    // The clocks of logs jitter: a gap of exactly the limit is none.
    if (sinceBefore + untilAfter <= limits.maxGap + kSameTime)
        return found(interpolatePose(before->second, after->second,
                                     sinceBefore / (sinceBefore + untilAfter)));
    if (std::min(sinceBefore, untilAfter) > slack) return {Result::inGap, std::nullopt};
    return found(sinceBefore < untilAfter ? before->second : after->second);
}

double secondsBetween(mrpt::Clock::time_point from, mrpt::Clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
}

void PoseTrack::add(Time time, const CPose3D& T_map_robot) {
    poses_.insert_or_assign(time, T_map_robot);
}

PoseAnswer PoseTrack::lookUp(Time time, const PoseLimits& limits) const {
    const auto after = poses_.lower_bound(time);
    return poseBetween(after == poses_.begin() ? nullptr : &*std::prev(after),
                       after == poses_.end() ? nullptr : &*after, time, limits);
}

}  // namespace superray
