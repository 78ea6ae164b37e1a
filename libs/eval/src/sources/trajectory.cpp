// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/math/CQuaternion.h>
#include <superray/eval/input_error.h>
#include <superray/eval/trajectory.h>
#include <superray/storage/atomic_file.h>

#include <cmath>
#include <cstdio>

#include "sources/text_numbers.h"
#include "text/text_input.h"

namespace superray {
namespace {

using mrpt::math::CQuaternionDouble;
using mrpt::poses::CPose3D;

constexpr std::size_t kTumColumns = 8, kMrptColumns = 7;

/// Seconds since 1970 must fit the 100 ns ticks of MRPT's clock.
constexpr double kLargestTime = 1e11;

CPose3D poseFromTum(const std::vector<double>& v) {
    const double norm = std::sqrt(v[4] * v[4] + v[5] * v[5] + v[6] * v[6] + v[7] * v[7]);
    if (std::abs(norm - 1) > 0.01)
        throw InputError("the quaternion qx qy qz qw has length " + std::to_string(norm) +
                         ", must be 1 (within 0.01)");
    const CQuaternionDouble q(v[7] / norm, v[4] / norm, v[5] / norm, v[6] / norm);
    return CPose3D(q, v[1], v[2], v[3]);
}

CPose3D poseFromMrpt(const std::vector<double>& v) {
    return CPose3D(v[1], v[2], v[3], v[4], v[5], v[6]);
}

}  // namespace

Trajectory Trajectory::load(const std::string& path) {
    std::istringstream file = openTextInput(path, LastLine::mustEnd);
    Trajectory result;
    std::string line;
    std::size_t columns = 0;
    for (std::size_t number = 1; std::getline(file, line); ++number) {
        if (isCommentLine(line)) continue;
        const auto fail = [&](const std::string& why) {
            throw InputError(path + ":" + std::to_string(number) + ": " + why);
        };
        const auto values = parseNumbers(line);
        if (!values) fail("every column must be a finite number, separated by blanks");
        if (columns == 0) columns = values->size();
        if (columns != kTumColumns && columns != kMrptColumns)
            fail("has " + std::to_string(columns) +
                 " columns; poses have 8 (TUM: t x y z qx qy qz qw) or 7 (MRPT: t x y z yaw "
                 "pitch roll)");
        if (values->size() != columns)
            fail("has " + std::to_string(values->size()) + " columns, the lines before have " +
                 std::to_string(columns));
        if (std::abs(values->front()) > kLargestTime)
            fail("time " + std::to_string(values->front()) +
                 " must be in seconds since 1970 (at most 1e11)");
        try {
            result.add(mrpt::Clock::fromDouble(values->front()),
                       columns == kTumColumns ? poseFromTum(*values) : poseFromMrpt(*values));
        } catch (const InputError& e) {
            fail(e.what());
        }
    }
    if (result.empty()) throw InputError(path + ": holds no pose");
    return result;
}

void Trajectory::saveTum(const std::string& path) const {
    AtomicStream file(path);
    file << "# timestamp x y z qx qy qz qw (robot pose in the map frame)\n";
    for (const auto& [time, pose] : poses()) {
        CQuaternionDouble q;
        pose.getAsQuaternion(q);
        char line[256];
        std::snprintf(line, sizeof line, "%.7f %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n",
                      mrpt::Clock::toDouble(time), pose.x(), pose.y(), pose.z(), q.x(), q.y(),
                      q.z(), q.r());
        file << line;
    }
    file.commit();
}

}  // namespace superray
