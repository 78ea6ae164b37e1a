// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file ros_recording.h
/// Files of ROS messages, whatever they are packed in.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "sources/object_reader.h"

namespace superray {

struct RosTopic {
    std::string name;      ///< e.g. "/scan"
    std::string type;      ///< e.g. "sensor_msgs/LaserScan", of ROS 1 and 2
    std::string encoding;  ///< "ros1" or "cdr"; others cannot be decoded

    bool operator<(const RosTopic& o) const {
        return std::tie(name, type, encoding) < std::tie(o.name, o.type, o.encoding);
    }
};

struct RosMessage {
    std::size_t topic;       ///< in topics()
    std::string_view bytes;  ///< until the next message is read
};

/// Reads messages in the order of the recording, one at a time.
class RosRecording {
 public:
    explicit RosRecording(std::string path) : path_(std::move(path)) {}
    virtual ~RosRecording() = default;
    RosRecording(const RosRecording&) = delete;
    RosRecording& operator=(const RosRecording&) = delete;

    /// Nothing at the end.
    /// \throws TruncatedInputError if what was read so far is whole, and the rest is missing
    /// \throws InputError if it is damaged, or cannot be read by this program
    virtual std::optional<RosMessage> next() = 0;

    /// Those of the messages so far.
    const std::vector<RosTopic>& topics() const { return topics_; }
    /// How many messages were read.
    std::uint64_t messages() const { return messages_; }
    const std::string& path() const { return path_; }

 protected:
    /// The topic's number; "sensor_msgs/msg/Image" becomes "sensor_msgs/Image".
    std::size_t topicNumber(std::string name, std::string type, std::string encoding);

    std::uint64_t messages_ = 0;

 private:
    std::string path_;
    std::vector<RosTopic> topics_;
    std::map<RosTopic, std::size_t> numbers_;
};

/// A recording of one file.
class RosFile : public RosRecording {
 public:
    using RosRecording::RosRecording;
    std::optional<RosMessage> next() final;

 protected:
    /// As next(); may throw MalformedBytes, too.
    virtual std::optional<RosMessage> read() = 0;
    /// See decompressChunk(); errors name the file.
    std::string unpacked(std::string_view codec, std::string_view packed,
                         std::uint64_t size) const;
};

/// ROS 1, version 2.0; `.bag`. Chunks may be plain, bz2 or lz4. Counts in the index must be
/// those of the chunks. \throws InputError
std::unique_ptr<RosRecording> openRos1Bag(const std::string& path);

/// ROS 2, SQLite; `.db3`. The structure of the file is checked if its state is not known.
/// \throws InputError; also if this program was built without SQLite
std::unique_ptr<RosRecording> openSqliteBag(const std::string& path, FileState state);

/// ROS 2, and whatever else has messages of ROS; `.mcap`. Chunks may be plain, lz4 or zstd;
/// check sums and counts must be right where there are any. \throws InputError
std::unique_ptr<RosRecording> openMcap(const std::string& path);

/// A folder of ROS 2: metadata.yaml, and the files that it lists, one after the other.
/// \throws InputError
std::unique_ptr<RosRecording> openBagFolder(const std::string& path, FileState state);

/// Any of them, by contents. \throws InputError, also if it is of another kind
std::unique_ptr<RosRecording> openRosRecording(const std::string& path,
                                               FileState state = FileState::unknown);

/// True for a folder that has metadata.yaml of ROS 2, or files of its bags.
bool isBagFolder(const std::string& path);

}  // namespace superray
