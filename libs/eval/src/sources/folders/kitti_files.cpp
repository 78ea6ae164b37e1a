// SPDX-License-Identifier: BSD-3-Clause
#include "sources/folders/kitti_files.h"

#include <mrpt/math/CMatrixFixed.h>
#include <superray/eval/input_error.h>

#include <cstring>
#include <sstream>

#include "sources/clouds/sensor_points.h"
#include "sources/file_bytes.h"
#include "sources/text_numbers.h"
#include "text/text_input.h"

namespace superray {

namespace fs = std::filesystem;
using Eigen::Isometry3d;

Isometry3d fromRowMajor(const std::vector<double>& v, const std::string& where) {
    if (v.size() != 12)
        throw InputError(where + ": has " + std::to_string(v.size()) +
                         " numbers, a 3x4 matrix has 12");
    Isometry3d T = Isometry3d::Identity();
    for (int row = 0; row < 3; ++row)
        for (int col = 0; col < 4; ++col)
            T.matrix()(row, col) = v[static_cast<std::size_t>(4 * row + col)];
    const Eigen::Matrix3d R = T.linear();
    if (!(R * R.transpose()).isIdentity(1e-3) || R.determinant() < 0)
        throw InputError(where + ": its left 3x3 part is not a rotation");
    return T;
}

mrpt::poses::CPose3D toPose(const Isometry3d& T) {
    mrpt::math::CMatrixDouble44 m;
    for (int row = 0; row < 4; ++row)
        for (int col = 0; col < 4; ++col) m(row, col) = T.matrix()(row, col);
    return mrpt::poses::CPose3D(m);
}

bool isKittiPoses(const std::string& path) {
    std::istringstream file = openTextInput(path, LastLine::any);
    std::string line;
    while (std::getline(file, line)) {
        if (isCommentLine(line)) continue;
        const auto numbers = parseNumbers(line);
        return numbers && numbers->size() == 12;
    }
    return false;
}

std::vector<mrpt::poses::CPose3D> readKittiPoses(const std::string& path) {
    std::vector<mrpt::poses::CPose3D> poses;
    forEachLine(path, [&](const std::string& line, const std::string& where) {
        poses.push_back(toPose(fromRowMajor(numbersOrThrow(line, where), where)));
    });
    return poses;
}

mrpt::maps::CSimplePointsMap::Ptr readKittiPoints(const fs::path& path) {
    constexpr std::size_t kPointBytes = 4 * sizeof(float);  // x y z reflectance
    const std::string bytes = readFileBytes(path.string());
    if (bytes.size() % kPointBytes != 0)
        throw InputError(path.string() + ": is truncated: its size " +
                         std::to_string(bytes.size()) +
                         " is not a multiple of 16 (x y z reflectance, float32)");
    std::vector<float> values(bytes.size() / sizeof(float));
    if (!values.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
    auto points = mrpt::maps::CSimplePointsMap::Create();
    points->reserve(values.size() / 4);
    try {
        for (std::size_t i = 0; i < values.size(); i += 4)
            addSensorPoint(*points, double{values[i]}, double{values[i + 1]},
                           double{values[i + 2]});
    } catch (const FarCoordinate& e) {
        throw InputError(path.string() + ": " + e.what());
    }
    points->mark_as_modified();
    return points;
}

}  // namespace superray
