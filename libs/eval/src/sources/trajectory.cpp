// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/math/CMatrixFixed.h>
#include <mrpt/math/CQuaternion.h>
#include <superray/eval/input_error.h>
#include <superray/eval/trajectory.h>
#include <superray/storage/atomic_file.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "sources/text_numbers.h"
#include "text/text_input.h"

namespace superray {
namespace {

using mrpt::math::CQuaternionDouble;
using mrpt::poses::CPose3D;

constexpr std::size_t kTumColumns = 8, kMrptColumns = 7, kMulRanColumns = 13;
constexpr char kByteOrderMark[] = "\xEF\xBB\xBF";  // of UTF-8

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

/// A time, then a matrix.
CPose3D poseFromMatrix(const std::vector<double>& v) {
    mrpt::math::CMatrixDouble44 m = mrpt::math::CMatrixDouble44::Identity();
    double deviation = 0;
    for (int row = 0; row < 3; ++row)
        for (int col = 0; col < 4; ++col)
            m(row, col) = v[static_cast<std::size_t>(1 + 4 * row + col)];
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) {
            double dot = a == b ? -1 : 0;
            for (int k = 0; k < 3; ++k) dot += m(a, k) * m(b, k);
            deviation = std::max(deviation, std::abs(dot));
        }
    if (deviation > 0.01) throw InputError("the left 3x3 part of the matrix is not a rotation");
    return CPose3D(m);
}

CPose3D poseFromRow(const std::vector<double>& v) {
    if (v.size() == kMulRanColumns) return poseFromMatrix(v);
    return v.size() == kTumColumns ? poseFromTum(v) : poseFromMrpt(v);
}

}  // namespace

Trajectory Trajectory::load(const std::string& path) {
    std::istringstream file = openTextInput(path, LastLine::mustEnd);
    Trajectory result;
    std::string line, firstBad;
    std::size_t columns = 0;
    bool first = true;
    for (std::size_t number = 1; std::getline(file, line); ++number) {
        if (number == 1 && line.rfind(kByteOrderMark, 0) == 0) line.erase(0, 3);
        if (isCommentLine(line)) continue;
        const bool isFirst = std::exchange(first, false);
        if (isFirst && isHeading(line)) continue;
        const auto fail = [&](const std::string& why) {
            throw InputError(path + ":" + std::to_string(number) + ": " + why);
        };
        const auto values = parseRow(line);
        if (!values) fail("every column must be a finite number, separated by blanks");
        if (columns == 0) columns = values->size();
        if (columns != kTumColumns && columns != kMrptColumns && columns != kMulRanColumns)
            fail("has " + std::to_string(columns) +
                 " columns; poses have 8 (TUM: t x y z qx qy qz qw), 7 (MRPT: t x y z yaw "
                 "pitch roll) or 13 (t [ns] and a 3x4 matrix)" +
                 (columns == 12 ? "; KITTI's 12 columns have no times: they fit folders with "
                                  "a scan a file"
                                : ""));
        if (values->size() != columns)
            fail("has " + std::to_string(values->size()) + " columns, the lines before have " +
                 std::to_string(columns));
        if (!std::all_of(values->begin(), values->end(),
                         [](double v) { return std::isfinite(v); })) {
            if (result.skippedRows_++ == 0)
                firstBad = path + ":" + std::to_string(number) +
                           ": every column must be a finite number";
            continue;
        }
        const double time =
            columns == kMulRanColumns ? values->front() * 1e-9 : values->front();
        if (std::abs(time) > kLargestTime)
            fail("time " + std::to_string(time) +
                 " must be in seconds since 1970 (at most 1e11)");
        try {
            result.add(mrpt::Clock::fromDouble(time), poseFromRow(*values));
        } catch (const InputError& e) {
            fail(e.what());
        }
    }
    if (result.empty() && !firstBad.empty()) throw InputError(firstBad);
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
