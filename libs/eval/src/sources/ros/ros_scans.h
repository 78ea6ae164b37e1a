// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file ros_scans.h
/// Messages of range sensors as MRPT's observations. All readers throw MalformedBytes.

#include <mrpt/img/TCamera.h>
#include <mrpt/obs/CObservation.h>

#include <string>

#include "sources/ros/message_cursor.h"
#include "sources/ros/ros_messages.h"

namespace superray {

/// Time stamp and sensor pose are those of the header's frame: what is left is where that
/// frame is on the robot.
struct RosScan {
    std::string frame;
    mrpt::obs::CObservation::Ptr observation;
};

/// sensor_msgs/PointCloud2 with x, y and z of 4 or 8 byte reals, of either byte order.
/// Points that are not finite stay: they are no returns.
RosScan readPointCloud2(MessageCursor& in);

/// sensor_msgs/LaserScan. Infinite or beyond range_max: no return. Not a number, or below
/// range_min: nothing is known.
RosScan readLaserScan(MessageCursor& in);

/// sensor_msgs/CameraInfo of one camera and resolution.
struct RosCamera {
    std::uint32_t columns = 0, rows = 0;
    std::string distortionModel;
    std::vector<double> distortion;
    std::array<double, 9> intrinsics{};   ///< K, of the image as it was taken
    std::array<double, 12> projection{};  ///< P, of the rectified image
    bool isPartial = false;               ///< binning or a region of interest

    bool operator==(const RosCamera& o) const;
};

RosCamera readCameraInfo(MessageCursor& in);

enum class Rectification : std::uint8_t {
    none,  ///< K and the distortion hold
    done   ///< P holds
};

/// True for sensor_msgs/Image of depths: 16UC1 [mm] and 32FC1 [m].
bool isDepthImage(MessageCursor in);

/// Such an image. 0 and values that are not finite are no returns.
RosScan readDepthImage(MessageCursor& in, const RosCamera& camera, Rectification done);

}  // namespace superray
