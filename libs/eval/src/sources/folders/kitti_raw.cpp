// SPDX-License-Identifier: BSD-3-Clause
// A drive of KITTI's raw data: velodyne_points and oxts. The robot is the inertial unit;
// the map is its first frame (x forward, y left, z up).

#include <mrpt/obs/CObservationPointCloud.h>
#include <superray/eval/input_error.h>

#include <cmath>
#include <cstring>
#include <ctime>
#include <utility>

#include "sources/clock_time.h"
#include "sources/folders/frame_source.h"
#include "sources/folders/kitti_files.h"
#include "sources/poses/matrix_pose.h"
#include "sources/text_numbers.h"

namespace superray {
namespace {

namespace fs = std::filesystem;
using Eigen::Isometry3d;
using mrpt::poses::CPose3D;

/// "2011-09-26 13:02:25.951199337", in UTC; nothing for other texts.
std::optional<Trajectory::Time> timeOfText(const std::string& text) {
    constexpr char kForm[] = "dddd-dd-dd dd:dd:dd", kDigits[] = "0123456789";
    constexpr std::size_t kLength = sizeof kForm - 1, kNanoDigits = 9;
    if (text.size() < kLength) return std::nullopt;
    for (std::size_t i = 0; i < kLength; ++i)
        if (kForm[i] == 'd' ? std::strchr(kDigits, text[i]) == nullptr || text[i] == '\0'
                            : text[i] != kForm[i])
            return std::nullopt;
    std::string fraction = text.substr(kLength);
    if (!fraction.empty() && (fraction[0] != '.' || fraction.size() == 1 ||
                              fraction.find_first_not_of(kDigits, 1) != std::string::npos))
        return std::nullopt;
    fraction = (fraction.empty() ? "" : fraction.substr(1)) + std::string(kNanoDigits, '0');
    const auto number = [&](std::size_t at, std::size_t digits) {
        return std::stoi(text.substr(at, digits));
    };
    std::tm date{};
    date.tm_year = number(0, 4) - 1900;
    date.tm_mon = number(5, 2) - 1;
    date.tm_mday = number(8, 2);
    date.tm_hour = number(11, 2);
    date.tm_min = number(14, 2);
    date.tm_sec = number(17, 2);
    // A day that no calendar has becomes another one.
    std::tm valid = date;
    const std::time_t seconds = timegm(&valid);
    if (date.tm_year < 70 || date.tm_year > 300 || valid.tm_mon != date.tm_mon ||
        valid.tm_mday != date.tm_mday || valid.tm_hour != date.tm_hour ||
        valid.tm_min != date.tm_min || valid.tm_sec != date.tm_sec)
        return std::nullopt;
    return timeOfStamp(seconds, std::stoi(fraction.substr(0, kNanoDigits)));
}

/// A time a line.
std::vector<Trajectory::Time> readTimes(const fs::path& path) {
    std::vector<Trajectory::Time> times;
    forEachLine(path, [&](std::string line, const std::string& where) {
        line.erase(line.find_last_not_of(" \t\r") + 1);
        const auto time = timeOfText(line);
        if (!time)
            throw InputError(where + ": time '" + line +
                             "' must be YYYY-MM-DD hh:mm:ss, with a point before decimals");
        times.push_back(*time);
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

/// Gives frames the poses of the oxts files with their names.
void readOxts(const fs::path& folder, std::vector<Frame>& frames) {
    std::optional<Isometry3d> first;
    double scale = 1;
    for (Frame& frame : frames) {
        const fs::path file = folder / "oxts" / "data" / (frame.file.stem().string() + ".txt");
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
        frame.T_map_robot = toPose(first->inverse() * poseOfOxts(row, scale));
    }
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
    const auto files = scansByFrame(velodyne / "data");
    if (files.empty()) throwNoScans(folder.string(), options, {});
    const auto times = readTimes(velodyne / "timestamps.txt");
    const std::size_t frames = files.rbegin()->first + 1;
    if (times.size() < frames)
        throw InputError((velodyne / "timestamps.txt").string() + ": has " +
                         std::to_string(times.size()) + " times for " + std::to_string(frames) +
                         " frames in velodyne_points/data/");
    FrameRecording recording;
    recording.path = folder.string();
    recording.label = "VELODYNE";
    for (const auto& [number, file] : files) {
        Frame frame{file, times[number], std::nullopt};
        frame.row = number;
        recording.frames.push_back(frame);
    }
    CPose3D sensorPose;
    if (options.poses == PoseOrigin::input) {
        readOxts(folder, recording.frames);
        sensorPose = velodyneOnImu(folder);
        recording.ownPoses = PoseSummary("oxts", files.size());
    }
    recording.read = [sensorPose](const Frame& frame) -> mrpt::obs::CObservation::Ptr {
        auto observation = mrpt::obs::CObservationPointCloud::Create();
        observation->sensorPose = sensorPose;
        observation->pointcloud = readKittiPoints(frame.file);
        return observation;
    };
    return makeFrameSource(std::move(recording), options);
}

}  // namespace superray
