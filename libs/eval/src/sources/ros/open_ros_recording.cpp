// SPDX-License-Identifier: BSD-3-Clause
#include "sources/ros/ros_recording.h"

namespace superray {

std::unique_ptr<RosRecording> openRosRecording(const std::string& path) {
    return openRos1Bag(path);
}

}  // namespace superray
