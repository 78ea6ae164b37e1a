// SPDX-License-Identifier: BSD-3-Clause
#include "sources/ros/ros_messages.h"

#include <mrpt/math/CQuaternion.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

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

/// Values from `first` up to `last`, with the digits that tell small differences.
std::string listed(const std::array<double, 7>& values, std::size_t first, std::size_t last) {
    std::string text;
    for (std::size_t i = first; i < last; ++i) {
        char number[40];
        std::snprintf(number, sizeof number, "%.9g", values[i]);
        text += (i > first ? ", " : "(") + std::string(number);
    }
    return text + ")";
}

double lengthOfQuaternion(const RosPose& pose) {
    double sum = 0;
    for (std::size_t i = 3; i < 7; ++i) sum += pose.values[i] * pose.values[i];
    return std::sqrt(sum);
}

}  // namespace

std::string RosPose::problem() const {
    double sum = 0;
    for (const double v : values) sum += v;
    if (!std::isfinite(sum)) return asText() + " is not finite";
    if (!(std::abs(lengthOfQuaternion(*this) - 1) < 0.1))
        return "the quaternion " + listed(values, 3, 7) + " is no rotation";
    return "";
}

std::string RosPose::asText() const {
    return listed(values, 0, 3) + " m, quaternion " + listed(values, 3, 7);
}

std::optional<mrpt::poses::CPose3D> RosPose::asPose() const {
    if (!problem().empty()) return std::nullopt;
    const double norm = lengthOfQuaternion(*this);
    const auto& v = values;
    return mrpt::poses::CPose3D(
        mrpt::math::CQuaternionDouble(v[6] / norm, v[3] / norm, v[4] / norm, v[5] / norm), v[0],
        v[1], v[2]);
}

RosPose rosPoseOf(const mrpt::poses::CPose3D& pose) {
    mrpt::math::CQuaternionDouble q;
    pose.getAsQuaternion(q);
    return {{pose.x(), pose.y(), pose.z(), q.x(), q.y(), q.z(), q.r()}};
}

bool areSame(const RosPose& a, const RosPose& b, double tolerance) {
    const double lengthA = lengthOfQuaternion(a), lengthB = lengthOfQuaternion(b);
    double apart = 0, minus = 0, plus = 0;
    for (std::size_t i = 0; i < 3; ++i) apart += std::pow(a.values[i] - b.values[i], 2);
    for (std::size_t i = 3; i < 7; ++i) {
        minus += std::pow(a.values[i] / lengthA - b.values[i] / lengthB, 2);
        plus += std::pow(a.values[i] / lengthA + b.values[i] / lengthB, 2);
    }
    // Small differences of quaternions are half the angle.
    const double angle = 2 * std::sqrt(std::min(minus, plus));
    return std::sqrt(apart) <= tolerance && angle <= tolerance;
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
