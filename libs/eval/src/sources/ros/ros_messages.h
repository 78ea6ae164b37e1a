// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file ros_messages.h
/// The messages that tell where things are. All readers throw MalformedBytes.

#include <mrpt/core/Clock.h>
#include <mrpt/poses/CPose3D.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sources/ros/message_cursor.h"

namespace superray {

struct RosHeader {
    mrpt::Clock::time_point time;  ///< mrpt::Clock::time_point() if the stamp is 0
    std::string frame;             ///< without a leading slash
};

/// A pose [m] as numbers: 56 bytes instead of CPose3D's several hundred.
struct RosPose {
    std::array<double, 7> values{};  ///< x y z, quaternion x y z w

    /// Nothing if a number is not finite, or the quaternion has not about length 1.
    std::optional<mrpt::poses::CPose3D> asPose() const;
    /// Why asPose() gives nothing, in words; empty if it gives a pose.
    std::string problem() const;
    /// E.g. "(0, 0, 1) m, quaternion (0, 0, 0, 1)".
    std::string asText() const;
    /// In all bits; see areSame().
    bool operator==(const RosPose& o) const { return values == o.values; }
};

RosPose rosPoseOf(const mrpt::poses::CPose3D& pose);

/// Whether two poses differ by no more than that, in [m] of their positions and [rad] of
/// their rotations (a quaternion and its negative are the same one).
/// \pre both have an asPose()
bool areSame(const RosPose& a, const RosPose& b, double tolerance);

/// T_parent_child, or of a robot frame in a fixed one.
struct RosTransform {
    RosHeader header;   ///< its frame is the parent, or the fixed one
    std::string child;  ///< without a leading slash; may be empty in odometry
    RosPose pose;
};

/// "/base_link" is "base_link".
std::string withoutSlash(std::string frame);

RosHeader readHeader(MessageCursor& in);

/// tf2_msgs/TFMessage, tf/tfMessage.
std::vector<RosTransform> readTransforms(MessageCursor& in);
/// nav_msgs/Odometry.
RosTransform readOdometry(MessageCursor& in);
/// geometry_msgs/PoseStamped; its child is empty.
RosTransform readPoseStamped(MessageCursor& in);
/// geometry_msgs/PoseWithCovarianceStamped; its child is empty.
RosTransform readPoseWithCovariance(MessageCursor& in);

}  // namespace superray
