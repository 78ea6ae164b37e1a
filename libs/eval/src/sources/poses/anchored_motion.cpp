// SPDX-License-Identifier: BSD-3-Clause
#include "sources/poses/anchored_motion.h"

#include <superray/maps/pose_track.h>

#include <algorithm>
#include <iterator>

namespace superray {

using mrpt::poses::CPose3D;

void AnchoredMotion::addAnchor(double at, const CPose3D& T_map_robot,
                               const CPose3D& T_odometry_robot) {
    anchors_.push_back({at, T_map_robot, T_odometry_robot});
}

CPose3D AnchoredMotion::pose(double at, const CPose3D& T_odometry_robot) const {
    const auto after =
        std::upper_bound(anchors_.begin(), anchors_.end(), at,
                         [](double value, const Anchor& a) { return value < a.at; });
    if (after == anchors_.begin()) return after->follow(T_odometry_robot);
    const auto before = std::prev(after);
    if (after == anchors_.end()) return before->follow(T_odometry_robot);
    return interpolatePose(before->follow(T_odometry_robot), after->follow(T_odometry_robot),
                           (at - before->at) / (after->at - before->at));
}

}  // namespace superray
