// SPDX-License-Identifier: BSD-3-Clause
#include "sources/folders/kitti_files.h"

#include <superray/eval/input_error.h>

#include <cstring>
#include <sstream>

#include "sources/clouds/sensor_points.h"
#include "sources/file_bytes.h"
#include "sources/folders/frame_source.h"
#include "sources/poses/matrix_pose.h"
#include "sources/text_numbers.h"
#include "text/text_input.h"

namespace superray {

namespace fs = std::filesystem;

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

std::map<std::size_t, fs::path> scansByFrame(const fs::path& folder) {
    std::map<std::size_t, fs::path> files;
    for (const auto& path : listFrames(folder, {".bin"})) {
        const auto frame = frameNumber(path.stem().string());
        if (!frame) throw InputError(path.string() + ": is not named by its frame number");
        if (!files.emplace(*frame, path).second)
            throw InputError(path.string() + ": frame " + std::to_string(*frame) +
                             " is there twice, see " + files[*frame].string());
    }
    return files;
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
