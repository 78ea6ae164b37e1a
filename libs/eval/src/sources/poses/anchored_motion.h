// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file anchored_motion.h
/// Odometry fixed to the map by a few known poses.

#include <mrpt/poses/CPose3D.h>

#include <vector>

namespace superray {

/// Odometry is smooth, but drifts; known poses are few. At each of them, the anchors, the
/// result is the known pose. Between two anchors it follows the odometry from either of
/// them, and goes from one to the other evenly, so that the drift is spread. Before the
/// first and after the last anchor it follows the odometry from that one.
class AnchoredMotion {
 public:
    /// \param at time or order, ascending from call to call
    /// \param T_map_robot the known pose
    /// \param T_odometry_robot what the odometry says there
    void addAnchor(double at, const mrpt::poses::CPose3D& T_map_robot,
                   const mrpt::poses::CPose3D& T_odometry_robot);

    /// \pre there is an anchor
    mrpt::poses::CPose3D pose(double at, const mrpt::poses::CPose3D& T_odometry_robot) const;

    std::size_t anchors() const { return anchors_.size(); }

 private:
    struct Anchor {
        double at;
        mrpt::poses::CPose3D T_map_robot, T_odometry_robot;
        mrpt::poses::CPose3D follow(const mrpt::poses::CPose3D& T_odometry_now) const {
            return T_map_robot + (T_odometry_now - T_odometry_robot);
        }
    };
    std::vector<Anchor> anchors_;
};

}  // namespace superray
