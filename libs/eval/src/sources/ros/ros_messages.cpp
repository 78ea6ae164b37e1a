// SPDX-License-Identifier: BSD-3-Clause
#include "sources/ros/ros_messages.h"

#include <mrpt/math/CQuaternion.h>

#include <cmath>

#include "sources/clock_time.h"

namespace superray {
namespace {

mrpt::Clock::time_point readStamp(MessageCursor& in) {
    const std::int64_t seconds = in.kind() == Serialisation::ros1
                                     ? std::int64_t{in.number<std::uint32_t>()}
                                     : std::int64_t{in.number<std::int32_t>()};
    const std::int64_t nanoseconds = in.number<std::uint32_t>();
    if (nanoseconds >= 1'000'000'000)
        throw MalformedBytes("a stamp has " + std::to_string(nanoseconds) + " nanoseconds");
    if (seconds == 0 && nanoseconds == 0) return {};
    return timeOfStamp(seconds, nanoseconds);
}

/// Translation or position, then rotation or orientation.
RosPose readPose(MessageCursor& in) {
    return {in.numbers<double, 7>()};
}

void skipCovariance(MessageCursor& in) {
    in.numbers<double, 36>();
}

}  // namespace

std::optional<mrpt::poses::CPose3D> RosPose::asPose() const {
    double sum = 0, norm = 0;
    for (const double v : values) sum += v;
    for (std::size_t i = 3; i < 7; ++i) norm += values[i] * values[i];
    norm = std::sqrt(norm);
    if (!std::isfinite(sum) || !(std::abs(norm - 1) < 0.1)) return std::nullopt;
    const auto& v = values;
    return mrpt::poses::CPose3D(
        mrpt::math::CQuaternionDouble(v[6] / norm, v[3] / norm, v[4] / norm, v[5] / norm), v[0],
        v[1], v[2]);
}

std::string withoutSlash(std::string frame) {
    return !frame.empty() && frame[0] == '/' ? frame.substr(1) : frame;
}

RosHeader readHeader(MessageCursor& in) {
    if (in.kind() == Serialisation::ros1) in.number<std::uint32_t>();  // sequence number
    RosHeader header;
    header.time = readStamp(in);
    header.frame = withoutSlash(in.text());
    return header;
}

std::vector<RosTransform> readTransforms(MessageCursor& in) {
    constexpr std::size_t kLeast = 72;  // stamp, two texts and seven numbers
    std::vector<RosTransform> all(in.count(kLeast));
    for (RosTransform& t : all) {
        t.header = readHeader(in);
        t.child = withoutSlash(in.text());
        t.pose = readPose(in);
    }
    in.expectEnd();
    return all;
}

RosTransform readOdometry(MessageCursor& in) {
    RosTransform t;
    t.header = readHeader(in);
    t.child = withoutSlash(in.text());
    t.pose = readPose(in);
    skipCovariance(in);
    in.numbers<double, 6>();  // twist
    skipCovariance(in);
    in.expectEnd();
    return t;
}

RosTransform readPoseStamped(MessageCursor& in) {
    RosTransform t;
    t.header = readHeader(in);
    t.pose = readPose(in);
    in.expectEnd();
    return t;
}

RosTransform readPoseWithCovariance(MessageCursor& in) {
    RosTransform t;
    t.header = readHeader(in);
    t.pose = readPose(in);
    skipCovariance(in);
    in.expectEnd();
    return t;
}

}  // namespace superray
