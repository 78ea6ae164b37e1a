// SPDX-License-Identifier: BSD-3-Clause
// A drive of KITTI's raw data: velodyne_points and oxts. The robot is the inertial unit;
// the map is its first frame (x forward, y left, z up).

#include <mrpt/obs/CObservationPointCloud.h>
#include <superray/eval/input_error.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <utility>

#include "sources/folders/frame_source.h"
#include "sources/folders/kitti_files.h"
#include "sources/poses/matrix_pose.h"
#include "sources/text_numbers.h"

namespace superray {
namespace {

namespace fs = std::filesystem;
using Eigen::Isometry3d;
using mrpt::poses::CPose3D;

/// "2011-09-26 13:02:25.951199337", in UTC, a line each.
std::vector<Trajectory::Time> readTimes(const fs::path& path) {
    std::vector<Trajectory::Time> times;
    forEachLine(path, [&](const std::string& line, const std::string& where) {
        std::tm date{};
        double seconds = 0;
        if (std::sscanf(line.c_str(), "%d-%d-%d %d:%d:%lf", &date.tm_year, &date.tm_mon,
                        &date.tm_mday, &date.tm_hour, &date.tm_min, &seconds) != 6 ||
            !(seconds >= 0 && seconds < 61) || date.tm_year < 1970 || date.tm_year > 2200 ||
            std::max({date.tm_mon, date.tm_mday, date.tm_hour, date.tm_min}) > 60 ||
            std::min({date.tm_mon, date.tm_mday, date.tm_hour, date.tm_min}) < 0)
            throw InputError(where + ": must be a time, YYYY-MM-DD hh:mm:ss");
        date.tm_year -= 1900;
        date.tm_mon -= 1;
        times.push_back(mrpt::Clock::fromDouble(static_cast<double>(timegm(&date)) + seconds));
    });
    return times;
}

/// Latitude, longitude [degrees], altitude [m], roll, pitch, yaw [rad] of a row of oxts, by
/// the Mercator projection that the benchmark's own tools use.
Isometry3d poseOfOxts(const std::vector<double>& v, double scale) {
    constexpr double kEarth = 6378137.0, kDegree = M_PI / 180;
    Isometry3d T = Isometry3d::Identity();
    T.translation() << scale * v[1] * kDegree * kEarth,
        scale * kEarth * std::log(std::tan((90 + v[0]) * kDegree / 2)), v[2];
    T.linear() = (Eigen::AngleAxisd(v[5], Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(v[4], Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(v[3], Eigen::Vector3d::UnitX()))
                     .toRotationMatrix();
    return T;
}

/// By frame: the rows of the oxts files with these names.
std::vector<std::optional<CPose3D>> readOxts(const fs::path& folder,
                                             const std::vector<fs::path>& scans) {
    std::vector<std::optional<CPose3D>> poses;
    std::optional<Isometry3d> first;
    double scale = 1;
    for (const auto& scan : scans) {
        const fs::path file = folder / "oxts" / "data" / (scan.stem().string() + ".txt");
        poses.emplace_back();
        if (!fs::exists(file)) continue;
        std::vector<double> row;
        forEachLine(file, [&](const std::string& line, const std::string& where) {
            row = numbersOrThrow(line, where);
        });
        if (row.size() < 6)
            throw InputError(file.string() +
                             ": must begin with lat lon alt roll pitch yaw, has " +
                             std::to_string(row.size()) + " numbers");
        if (!(std::abs(row[0]) < 90))
            throw InputError(file.string() + ": latitude " + std::to_string(row[0]) +
                             " must be between -90 and 90 degrees");
        if (!first) {
            scale = std::cos(row[0] * M_PI / 180);
            first = poseOfOxts(row, scale);
        }
        poses.back() = toPose(first->inverse() * poseOfOxts(row, scale));
    }
    return poses;
}

/// Rows 'R:' and 'T:' of calib_imu_to_velo.txt, beside the drive or one level up.
CPose3D velodyneOnImu(const fs::path& folder) {
    const fs::path above = fs::absolute(folder / "").lexically_normal().parent_path();
    for (const fs::path& place : {folder, above.parent_path()}) {
        const fs::path path = place / "calib_imu_to_velo.txt";
        if (!fs::exists(path)) continue;
        std::vector<double> R, T;
        forEachLine(path, [&](const std::string& line, const std::string& where) {
            for (const auto& [key, row] : {std::pair{"R:", &R}, std::pair{"T:", &T}}) {
                if (line.rfind(key, 0) != 0) continue;
                if (!row->empty()) throw InputError(where + ": second row '" + key + "'");
                *row = numbersOrThrow(line.substr(2), where);
            }
        });
        if (R.size() != 9 || T.size() != 3)
            throw InputError(path.string() + ": must have rows R: (9 numbers) and T: (3)");
        const Isometry3d T_velo_imu = fromRowMajor(
            {R[0], R[1], R[2], T[0], R[3], R[4], R[5], T[1], R[6], R[7], R[8], T[2]},
            path.string());
        return toPose(T_velo_imu.inverse());
    }
    throw InputError(folder.string() + ": calib_imu_to_velo.txt is neither in it nor in " +
                     above.parent_path().string());
}

}  // namespace

std::unique_ptr<ScanSource> openKittiRaw(const fs::path& folder,
                                         const ScanSourceOptions& options) {
    const fs::path velodyne = folder / "velodyne_points";
    const auto files = listFrames(velodyne / "data", {".bin"});
    if (files.empty()) throwNoScans(folder.string(), options, {});
    const auto times = readTimes(velodyne / "timestamps.txt");
    if (times.size() < files.size())
        throw InputError((velodyne / "timestamps.txt").string() + ": has " +
                         std::to_string(times.size()) + " times for " +
                         std::to_string(files.size()) + " scans");
    FrameRecording recording;
    recording.path = folder.string();
    recording.label = "VELODYNE";
    std::vector<std::optional<CPose3D>> poses(files.size());
    CPose3D sensorPose;
    if (options.poses == PoseOrigin::input) {
        poses = readOxts(folder, files);
        sensorPose = velodyneOnImu(folder);
        recording.ownPoses = PoseSummary("oxts", poses.size());
    }
    for (std::size_t i = 0; i < files.size(); ++i)
        recording.frames.push_back({files[i], times[i], poses[i]});
    recording.read = [sensorPose](const Frame& frame) -> mrpt::obs::CObservation::Ptr {
        auto observation = mrpt::obs::CObservationPointCloud::Create();
        observation->sensorPose = sensorPose;
        observation->pointcloud = readKittiPoints(frame.file);
        return observation;
    };
    return makeFrameSource(std::move(recording), options);
}

}  // namespace superray
