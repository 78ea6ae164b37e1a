// SPDX-License-Identifier: BSD-3-Clause
// Folders of the KITTI odometry benchmark, and of .bin files that are named by time.

#include <mrpt/obs/CObservationPointCloud.h>
#include <superray/eval/input_error.h>

#include <cmath>

#include "sources/folders/frame_source.h"
#include "sources/folders/kitti_files.h"
#include "sources/poses/matrix_pose.h"
#include "sources/text_numbers.h"

namespace superray {
namespace {

namespace fs = std::filesystem;
using Eigen::Isometry3d;

Isometry3d readCalibration(const fs::path& path) {
    std::optional<Isometry3d> T_cam_velo;
    forEachLine(path, [&](const std::string& line, const std::string& where) {
        if (line.rfind("Tr:", 0) != 0) return;
        if (T_cam_velo) throw InputError(where + ": second row 'Tr:'");
        T_cam_velo = fromRowMajor(numbersOrThrow(line.substr(3), where), where);
    });
    if (!T_cam_velo)
        throw InputError(path.string() + ": has no row 'Tr:' (Velodyne to camera 0)");
    return *T_cam_velo;
}

/// The folder may be a symbolic link: its poses may be where the link is, or where the
/// folder is.
fs::path findPoses(const fs::path& folder) {
    const fs::path given = fs::absolute(folder / "").lexically_normal().parent_path();
    const fs::path real = fs::canonical(folder);
    std::string tried;
    for (const fs::path& place : {given, real}) {
        const fs::path name = place.filename().string() + ".txt";
        for (const auto& candidate : {place / "poses.txt", place / "poses" / name,
                                      place.parent_path().parent_path() / "poses" / name}) {
            if (fs::exists(candidate)) return candidate;
            tried += (tried.empty() ? "" : ", ") + candidate.string();
        }
        if (given == real) break;
    }
    throw InputError(folder.string() + ": has no poses (looked for poses.txt and " + tried +
                     "); give a poses file (--poses FILE)");
}

/// From the first camera's frame (x right, y down, z forward) to the map's
/// (x forward, y left, z up).
Isometry3d cameraToMap() {
    Isometry3d T = Isometry3d::Identity();
    T.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    return T;
}

void checkCount(const fs::path& path, const char* what, std::size_t count, std::size_t frames) {
    if (count < frames)
        throw InputError(path.string() + ": has " + std::to_string(count) + " " + what +
                         " for " + std::to_string(frames) + " frames in velodyne/");
}

std::vector<Trajectory::Time> readTimes(const fs::path& folder, std::size_t frames) {
    constexpr double kLargestTime = 1e11;  // s, that MRPT's clock counts
    constexpr double kPeriod = 0.1;        // s, of KITTI's Velodyne
    std::vector<Trajectory::Time> times;
    if (fs::exists(folder / "times.txt")) {
        forEachLine(folder / "times.txt", [&](const std::string& l, const std::string& at) {
            const auto values = numbersOrThrow(l, at);
            if (values.size() != 1) throw InputError(at + ": must be one number");
            if (!(std::abs(values.front()) <= kLargestTime))
                throw InputError(at + ": time " + std::to_string(values.front()) +
                                 " must be in seconds, at most 1e11");
            times.push_back(mrpt::Clock::fromDouble(values.front()));
        });
        checkCount(folder / "times.txt", "times", times.size(), frames);
    } else {
        for (std::size_t i = 0; i < frames; ++i)
            times.push_back(mrpt::Clock::fromDouble(kPeriod * static_cast<double>(i)));
    }
    return times;
}

/// \param path of the poses; empty: where the benchmark puts them
std::vector<mrpt::poses::CPose3D> readPoses(const fs::path& folder, fs::path path,
                                            std::size_t frames) {
    const Isometry3d T_cam_velo = readCalibration(folder / "calib.txt");
    if (path.empty()) path = findPoses(folder);
    std::vector<mrpt::poses::CPose3D> poses;
    forEachLine(path, [&](const std::string& line, const std::string& where) {
        const Isometry3d T_first_cam = fromRowMajor(numbersOrThrow(line, where), where);
        poses.push_back(toPose(cameraToMap() * T_first_cam * T_cam_velo));
    });
    checkCount(path, "poses", poses.size(), frames);
    return poses;
}

mrpt::obs::CObservation::Ptr readScan(const Frame& frame) {
    auto observation = mrpt::obs::CObservationPointCloud::Create();
    observation->pointcloud = readKittiPoints(frame.file);
    return observation;
}

}  // namespace

std::unique_ptr<ScanSource> openKitti(const fs::path& folder, const ScanSourceOptions& asked) {
    const auto files = scansByFrame(folder / "velodyne");
    if (files.empty())
        throw InputError(folder.string() +
                         ": is not a KITTI odometry folder: it has no velodyne/*.bin");
    const std::size_t frameCount = files.rbegin()->first + 1;
    const auto times = readTimes(folder, frameCount);
    ScanSourceOptions options = asked;
    FrameRecording recording;
    recording.path = folder.string();
    recording.label = "VELODYNE";
    recording.read = readScan;
    std::vector<mrpt::poses::CPose3D> own;
    if (options.poses == PoseOrigin::input) {
        own = readPoses(folder, {}, frameCount);
        recording.ownPoses = PoseSummary("poses of the folder", own.size());
    } else if (options.poses == PoseOrigin::file && isKittiPoses(options.posesFile)) {
        // Of the left camera, as the benchmark's own.
        own = readPoses(folder, options.posesFile, frameCount);
        recording.ownPoses = PoseSummary("file '" + options.posesFile + "'", own.size());
        options.poses = PoseOrigin::input;
    }
    recording.isTimed = fs::exists(folder / "times.txt");
    for (const auto& [index, file] : files) {
        Frame frame{file, times[index], std::nullopt};
        if (!own.empty()) frame.T_map_robot = own[index];
        recording.frames.push_back(frame);
    }
    return makeFrameSource(std::move(recording), options);
}

std::unique_ptr<ScanSource> openTimedBins(const fs::path& folder,
                                          const ScanSourceOptions& options) {
    FrameRecording recording;
    recording.path = folder.string();
    recording.label = "LIDAR";
    recording.read = readScan;
    addNamedFrames(listFrames(folder, {".bin"}), recording);
    refuseTwins(recording);
    return makeFrameSource(std::move(recording), options);
}

}  // namespace superray
