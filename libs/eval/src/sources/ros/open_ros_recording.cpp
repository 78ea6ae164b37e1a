// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>

#include <filesystem>

#include "sources/file_bytes.h"
#include "sources/ros/ros_recording.h"

namespace superray {

std::unique_ptr<RosRecording> openRosRecording(const std::string& path, FileState state) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) return openBagFolder(path, state);
    requireRegularFile(path);
    const std::string start = startOfFile(path);
    const auto begins = [&](const std::string& magic) { return start.rfind(magic, 0) == 0; };
    if (begins("#ROSBAG V")) return openRos1Bag(path);
    if (begins("\x89MCAP")) return openMcap(path);
    if (begins("SQLite format 3")) return openSqliteBag(path, state);
    throw InputError(path +
                     ": is no recording of ROS: it begins neither as a bag of ROS 1, nor as "
                     "MCAP, nor as SQLite (.db3)");
}

}  // namespace superray
