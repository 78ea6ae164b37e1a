// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/math/CMatrixFixed.h>
#include <mrpt/math/CQuaternion.h>
#include <superray/eval/input_error.h>
#include <superray/eval/trajectory.h>
#include <superray/storage/atomic_file.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>
#include <vector>

#include "sources/poses/matrix_pose.h"
#include "sources/poses/pose_columns.h"
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

CPose3D poseFromTum(const std::vector<double>& v, const std::string& where) {
    const double norm = std::sqrt(v[4] * v[4] + v[5] * v[5] + v[6] * v[6] + v[7] * v[7]);
    if (std::abs(norm - 1) > 0.01)
        throw InputError(where + ": the quaternion qx qy qz qw has length " +
                         std::to_string(norm) + ", must be 1 (within 0.01)");
    const CQuaternionDouble q(v[7] / norm, v[4] / norm, v[5] / norm, v[6] / norm);
    return CPose3D(q, v[1], v[2], v[3]);
}

CPose3D poseFromMrpt(const std::vector<double>& v) {
    return CPose3D(v[1], v[2], v[3], v[4], v[5], v[6]);
}

CPose3D poseFromRow(const std::vector<double>& v, const std::string& where) {
    if (v.size() == kMulRanColumns)
        return toPose(fromRowMajor({v.begin() + 1, v.end()}, where));
    return v.size() == kTumColumns ? poseFromTum(v, where) : poseFromMrpt(v);
}

void checkColumns(std::size_t columns, const PoseColumns& named, const std::string& where) {
    if (columns != kTumColumns && columns != kMrptColumns && columns != kMulRanColumns)
        throw InputError(where + ": has " + std::to_string(columns) +
                         " columns; poses have 8 (TUM: t x y z qx qy qz qw), 7 (MRPT: t x y z "
                         "yaw pitch roll) or 13 (t [ns] and a 3x4 matrix)" +
                         (columns == 12 ? "; KITTI's 12 columns have no times: they fit "
                                          "folders with a scan a file"
                                        : ""));
    if (columns == kTumColumns) named.check({"t", "x", "y", "z", "qx", "qy", "qz", "qw"});
    if (columns == kMrptColumns) named.check({"t", "x", "y", "z", "yaw", "pitch", "roll"});
}

/// The lines that the poses of a file are in, by time.
class SeenTimes {
 public:
    /// \return false if the same pose was seen at this time
    /// \throws InputError if another one was
    bool add(Trajectory::Time time, const CPose3D& pose, std::size_t line,
             const std::string& where) {
        const auto [seen, isNew] = seen_.emplace(time, std::pair{line, pose});
        if (isNew) return true;
        constexpr double kRounding = 1e-9;
        const auto a = pose.getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>(),
                   b = seen->second.second
                           .getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>();
        for (int row = 0; row < 3; ++row)
            for (int col = 0; col < 4; ++col)
                if (!(std::abs(a(row, col) - b(row, col)) <= kRounding))
                    throw InputError(
                        where + ": time " + std::to_string(mrpt::Clock::toDouble(time)) +
                        " has another pose than in line " + std::to_string(seen->second.first));
        return false;
    }

 private:
    std::map<Trajectory::Time, std::pair<std::size_t, CPose3D>> seen_;
};

}  // namespace

Trajectory Trajectory::load(const std::string& path) {
    std::istringstream file = openTextInput(path, LastLine::mustEnd);
    Trajectory result;
    std::string line, firstBad;
    std::size_t columns = 0;
    PoseColumns named;
    SeenTimes seen;
    bool first = true;
    for (std::size_t number = 1; std::getline(file, line); ++number) {
        if (number == 1 && line.rfind(kByteOrderMark, 0) == 0) line.erase(0, 3);
        const std::string where = path + ":" + std::to_string(number);
        if (isCommentLine(line)) {
            if (columns == 0) named.seeComment(line, where);
            continue;
        }
        if (std::exchange(first, false) && isHeading(line)) {
            named.seeHeading(line, where);
            continue;
        }
        const auto values = rowOrThrow(line, where);
        if (columns == 0) checkColumns(columns = values.size(), named, where);
        if (values.size() != columns)
            throw InputError(where + ": has " + std::to_string(values.size()) +
                             " columns, the lines before have " + std::to_string(columns));
        if (!std::all_of(values.begin(), values.end(),
                         [](double v) { return std::isfinite(v); })) {
            if (result.skippedRows_++ == 0)
                firstBad = where + ": every column must be a finite number";
            continue;
        }
        const double time = columns == kMulRanColumns ? values.front() * 1e-9 : values.front();
        if (std::abs(time) > kLargestTime)
            throw InputError(where + ": time " + std::to_string(time) +
                             " must be in seconds since 1970 (at most 1e11)");
        const auto stamp = mrpt::Clock::fromDouble(time);
        const CPose3D pose = poseFromRow(values, where);
        if (seen.add(stamp, pose, number, where)) result.add(stamp, pose);
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
