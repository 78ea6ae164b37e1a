// SPDX-License-Identifier: BSD-3-Clause
#include "sources/poses/pose_streams.h"

#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <cmath>

namespace superray {
namespace {

using mrpt::poses::CPose3D;

bool isIdentity(const CPose3D& pose) {
    constexpr double kNothing = 1e-9;  // [m] and [rad]: rounding of text logs
    return pose.norm() < kNothing && std::abs(pose.yaw()) < kNothing &&
           std::abs(pose.pitch()) < kNothing && std::abs(pose.roll()) < kNothing;
}

}  // namespace

bool isFinite(const CPose3D& pose) {
    double sum = pose.x() + pose.y() + pose.z();
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) sum += pose.getRotationMatrix()(i, k);
    return std::isfinite(sum);
}

void PoseStream::add(const Place& place, const CPose3D& pose) {
    if (isFinite(pose))
        entries.push_back({place, pose});
    else
        ++notFinite;
}

void PoseStreams::add(const mrpt::obs::CObservation& observation, const Place& place) {
    using mrpt::obs::CObservationOdometry;
    using mrpt::obs::CObservationRobotPose;
    if (const auto* p = dynamic_cast<const CObservationRobotPose*>(&observation))
        robotPoses[p->sensorLabel].add(place, p->pose.mean);
    else if (const auto* o = dynamic_cast<const CObservationOdometry*>(&observation))
        odometry[o->sensorLabel].add(place, CPose3D(o->odometry));
}

bool PoseStreams::addAction(const CPose3D& increment, const Place& place) {
    if (!isFinite(increment)) return false;
    actionsMove = actionsMove || !isIdentity(increment);
    const CPose3D before = actions.empty() ? CPose3D() : actions.entries.back().pose;
    actions.add(place, before + increment);
    return true;
}

}  // namespace superray
