// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// ROS recordings made message by message: what a first pass over them learns, and their file.

#include <superray/eval/input_error.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "eval/sources/format_samples.h"
#include "eval/temp_folder.h"
#include "sources/ros/robot_frame.h"

namespace superray::test {

inline constexpr double kStart = 1000;  // [s]

/// Bytes of ROS 1 messages.
class Bytes {
 public:
    template <class T>
    Bytes& add(T value) {
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
        return *this;
    }
    Bytes& add(const char* text) { return add(std::string(text)); }
    Bytes& add(const std::string& text) {
        add(static_cast<std::uint32_t>(text.size()));
        bytes_ += text;
        return *this;
    }
    /// \param seconds after kStart: a stamp of 0 means that none is known
    Bytes& header(double seconds, const std::string& frame) {
        const double whole = std::floor(kStart + seconds);
        add(std::uint32_t{0}).add(static_cast<std::uint32_t>(whole));
        return add(static_cast<std::uint32_t>((kStart + seconds - whole) * 1e9)).add(frame);
    }
    Bytes& pose(double x, double yaw) {
        return pose({x, 0.0, 0.0, 0.0, 0.0, std::sin(yaw / 2), std::cos(yaw / 2)});
    }
    /// x y z, quaternion x y z w.
    Bytes& pose(const std::array<double, 7>& values) {
        for (const double v : values) add(v);
        return *this;
    }
    Bytes& plain(const std::string& bytes) {
        bytes_ += bytes;
        return *this;
    }
    Bytes& zeros(int count) {
        for (int i = 0; i < count; ++i) add(0.0);
        return *this;
    }
    const std::string& text() const { return bytes_; }

 private:
    std::string bytes_;
};

/// A recording in memory, and what a first pass makes of it.
class Recording final : public RosRecording {
 public:
    explicit Recording(const ScanSourceOptions& options = {})
        : RosRecording("memory"), contents_(options) {}

    void add(const std::string& topic, const std::string& type, const Bytes& bytes) {
        const std::size_t number = topicNumber(topic, type, "ros1");
        contents_.add(*this, {number, bytes.text()});
        all_.emplace_back(number, bytes.text());
    }
    void tf(double seconds, const std::string& parent, const std::string& child,
            const std::array<double, 7>& pose, const std::string& topic) {
        Bytes bytes;
        bytes.add(std::uint32_t{1}).header(seconds, parent).add(child).pose(pose);
        add(topic, "tf2_msgs/TFMessage", bytes);
    }
    void tf(double seconds, const std::string& parent, const std::string& child, double x,
            double yaw = 0, const std::string& topic = "/tf") {
        Bytes bytes;
        bytes.add(std::uint32_t{1}).header(seconds, parent).add(child).pose(x, yaw);
        add(topic, "tf2_msgs/TFMessage", bytes);
    }
    void fixed(const std::string& parent, const std::string& child, double x, double yaw = 0) {
        tf(0, parent, child, x, yaw, "/tf_static");
    }
    void odometry(double seconds, const std::string& frame, const std::string& child, double x,
                  const std::string& topic = "/odom") {
        Bytes bytes;
        bytes.header(seconds, frame).add(child).pose(x, 0).zeros(36 + 6 + 36);
        add(topic, "nav_msgs/Odometry", bytes);
    }
    void poseStamped(double seconds, const std::string& frame, double x,
                     const std::string& topic) {
        Bytes bytes;
        bytes.header(seconds, frame).pose(x, 0);
        add(topic, "geometry_msgs/PoseStamped", bytes);
    }
    /// Of one point, 2 m ahead.
    void cloud(double seconds, const std::string& frame, const std::string& topic = "/points") {
        Bytes bytes;
        bytes.header(seconds, frame).add(1u).add(1u).add(3u);
        std::uint32_t offset = 0;
        for (const char* axis : {"x", "y", "z"}) {
            bytes.add(axis).add(offset).add(std::uint8_t{7}).add(1u);
            offset += 4;
        }
        bytes.add(std::uint8_t{0}).add(12u).add(12u);
        bytes.add(12u).add(2.0f).add(0.0f).add(0.0f).add(std::uint8_t{1});
        add(topic, "sensor_msgs/PointCloud2", bytes);
    }

    std::optional<RosMessage> next() override { return std::nullopt; }
    const RosContents& contents() const { return contents_; }
    RobotFrame robot(const ScanSourceOptions& options = {}) const {
        return chooseRobotFrame(contents_, options, "memory");
    }
    std::string error() const {
        return messageOf<InputError>([&] { robot(); });
    }
    PoseStreams poses() const { return robotPoses(contents_, robot().name, limits()).streams; }

    /// As an MCAP file without chunks and index.
    std::string mcap() const {
        const std::string magic = "\x89MCAP0\r\n";
        std::string file = magic + record(1, Bytes().add("ros1").add("test"));
        for (std::size_t i = 0; i < topics().size(); ++i) {
            const auto number = static_cast<std::uint16_t>(i + 1);
            file += record(3, Bytes().add(number).add(topics()[i].type).add("ros1msg").add(""));
            file += record(
                4, Bytes().add(number).add(number).add(topics()[i].name).add("ros1").add(0u));
        }
        std::uint64_t time = 0;
        for (const auto& [topic, bytes] : all_) {
            const auto number = static_cast<std::uint16_t>(topic + 1);
            ++time;
            file += record(5, Bytes().add(number).add(0u).add(time).add(time).plain(bytes));
        }
        return file + record(15, Bytes().add(0u)) +
               record(2, Bytes().add(std::uint64_t{0}).add(std::uint64_t{0}).add(0u)) + magic;
    }
    Built build(const ScanSourceOptions& options = {}) const {
        TempFolder folder;
        return test::build(folder.write("a.mcap", mcap()), options);
    }
    std::string buildError(const ScanSourceOptions& options = {}) const {
        return messageOf<InputError>([&] { build(options); });
    }

    static PoseLimits limits() {
        PoseLimits limits;
        limits.maxGap = 2;
        return limits;
    }

 private:
    static std::string record(std::uint8_t kind, const Bytes& bytes) {
        const std::uint64_t size = bytes.text().size();
        return Bytes().add(kind).add(size).plain(bytes.text()).text();
    }

    RosContents contents_;
    std::vector<std::pair<std::size_t, std::string>> all_;  // topic, bytes
};

}  // namespace superray::test
