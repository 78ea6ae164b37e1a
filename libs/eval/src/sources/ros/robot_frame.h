// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file robot_frame.h
/// The frame of a ROS recording that is the robot, its poses, and where sensors are on it.

#include <superray/eval/scan_source.h>

#include <map>
#include <string>

#include "sources/poses/pose_streams.h"
#include "sources/ros/ros_contents.h"

namespace superray {

/// The robot's frame, and the way to it from the frame of every scan.
struct RobotFrame {
    std::string name;
    std::map<std::string, FramePath> mounts;  ///< by the frame of the scans

    /// T_robot_frame of a scan's frame at a time.
    PoseAnswer mountAt(const std::string& scanFrame, mrpt::Clock::time_point time,
                       const PoseLimits& limits) const;
};

/// Moves the sensor pose of a scan from its frame to the robot.
void mount(const RosScan& scan, const mrpt::poses::CPose3D& T_robot_frame);

/// The first of these that all scans have transforms to: base_link, base_footprint (or such
/// in a namespace), the child frame of an odometry. Where none is told, or the poses are
/// not from the recording: the top of /tf_static above the scans.
/// \throws InputError naming the frames, if there is none, or if transforms on the way
///         to them contradict each other
RobotFrame chooseRobotFrame(const RosContents& contents, const ScanSourceOptions& options,
                            const std::string& what);

/// Poses that a recording has.
struct RosPoses {
    PoseStreams streams;
    std::string unusable;  ///< in words; empty: nothing
    /// Topics that cannot be poses of the robot, with the reason.
    std::map<std::string, std::string> notOfRobot;
    /// What contradicts itself in the transforms that poses need, by their label.
    std::map<std::string, std::string> contradictions;
};

/// All poses of the robot's frame. Labels of robot poses: topics of poses, and "tf FRAME" for
/// the root of the moving transforms. Labels of odometry: topics, and "tf FRAME" for frames
/// between root and robot that no odometry topic tells. Topics of poses in a frame that is
/// fixed to the robot are left out: they tell where something is that the robot sees.
RosPoses robotPoses(const RosContents& contents, const std::string& robotFrame,
                    const PoseLimits& limits);

}  // namespace superray
