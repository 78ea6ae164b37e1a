// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file ros_recording.h
/// Files of ROS messages, whatever they are packed in.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sources/object_reader.h"

namespace superray {

struct RosTopic {
    std::string name;      ///< e.g. "/scan"
    std::string type;      ///< e.g. "sensor_msgs/LaserScan", of ROS 1 and 2
    std::string encoding;  ///< "ros1" or "cdr"; others cannot be decoded

    bool operator==(const RosTopic& o) const {
        return name == o.name && type == o.type && encoding == o.encoding;
    }
};

struct RosMessage {
    std::size_t topic;       ///< in topics()
    std::string_view bytes;  ///< until the next message is read
};

/// Reads messages in the order of the file, one at a time.
class RosRecording {
 public:
    explicit RosRecording(std::string path) : path_(std::move(path)) {}
    virtual ~RosRecording() = default;
    RosRecording(const RosRecording&) = delete;
    RosRecording& operator=(const RosRecording&) = delete;

    /// Nothing at the end.
    /// \throws TruncatedInputError if what was read so far is whole, and the rest is missing
    /// \throws InputError if it is damaged, or cannot be read by this program
    std::optional<RosMessage> next();

    /// Those of the messages so far.
    const std::vector<RosTopic>& topics() const { return topics_; }
    std::uint64_t messages() const { return messages_; }
    const std::string& path() const { return path_; }

 protected:
    /// As next(); may throw MalformedBytes, too.
    virtual std::optional<RosMessage> read() = 0;

    /// The topic's number; "sensor_msgs/msg/Image" becomes "sensor_msgs/Image".
    std::size_t topicNumber(std::string name, std::string type, std::string encoding);

 private:
    std::string path_;
    std::vector<RosTopic> topics_;
    std::uint64_t messages_ = 0;
};

/// ROS 1, version 2.0; `.bag`. Chunks may be plain, bz2 or lz4. Counts in the index must be
/// those of the chunks. \throws InputError
std::unique_ptr<RosRecording> openRos1Bag(const std::string& path);

/// ROS 1, ROS 2, by contents. \throws InputError, also if it is of another kind
std::unique_ptr<RosRecording> openRosRecording(const std::string& path);

}  // namespace superray
