// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/math/CMatrixFixed.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <superray/eval/input_error.h>

#include <Eigen/Geometry>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <vector>

#include "sources/scan_source_formats.h"
#include "sources/text_numbers.h"
#include "text/text_input.h"

namespace superray {
namespace {

namespace fs = std::filesystem;
using Eigen::Isometry3d;

/// A 3x4 matrix in row-major order, as KITTI writes poses and calibrations.
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

/// Calls `visit(line, where)` for every line with data of a text file.
template <class Visit>
void forEachLine(const fs::path& path, const Visit& visit) {
    std::istringstream file = openTextInput(path.string(), LastLine::mustEnd);
    std::string line;
    for (std::size_t number = 1; std::getline(file, line); ++number)
        if (!isCommentLine(line)) visit(line, path.string() + ":" + std::to_string(number));
}

std::vector<double> numbersOrThrow(const std::string& text, const std::string& where) {
    auto numbers = parseNumbers(text);
    if (!numbers)
        throw InputError(where + ": every column must be a finite number, separated by blanks");
    return *numbers;
}

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

fs::path findPoses(const fs::path& folder) {
    const fs::path name = fs::canonical(folder).filename().string() + ".txt";
    for (const auto& candidate :
         {folder / "poses.txt", folder / "poses" / name, folder / ".." / ".." / "poses" / name})
        if (fs::exists(candidate)) return candidate;
    throw InputError(folder.string() + ": has no poses (looked for poses.txt, poses/" +
                     name.string() + " and ../../poses/" + name.string() +
                     "); give a poses file (--poses FILE)");
}

/// From the first camera's frame (x right, y down, z forward) to the map's
/// (x forward, y left, z up).
Isometry3d cameraToMap() {
    Isometry3d T = Isometry3d::Identity();
    T.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    return T;
}

mrpt::poses::CPose3D toPose(const Isometry3d& T) {
    mrpt::math::CMatrixDouble44 m;
    for (int row = 0; row < 4; ++row)
        for (int col = 0; col < 4; ++col) m(row, col) = T.matrix()(row, col);
    return mrpt::poses::CPose3D(m);
}

mrpt::maps::CSimplePointsMap::Ptr readPoints(const fs::path& path) {
    constexpr std::size_t kPointBytes = 4 * sizeof(float);  // x y z reflectance
    requireRegularFile(path.string());
    const auto bytes = fs::file_size(path);
    if (bytes % kPointBytes != 0)
        throw InputError(path.string() + ": is truncated: its size " + std::to_string(bytes) +
                         " is not a multiple of 16 (x y z reflectance, float32)");
    std::vector<float> values(bytes / sizeof(float));
    std::ifstream file(path, std::ios::binary);
    if (!file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(bytes)))
        throw InputError(path.string() + ": cannot be read");
    auto points = mrpt::maps::CSimplePointsMap::Create();
    points->reserve(values.size() / 4);
    for (std::size_t i = 0; i < values.size(); i += 4)
        points->insertPointFast(values[i], values[i + 1], values[i + 2]);
    points->mark_as_modified();
    return points;
}

class KittiSource final : public ScanSource {
 public:
    KittiSource(const fs::path& folder, const ScanSourceOptions& options) : lookup_(options) {
        if (!acceptsLabel(options, kLabel))
            throw InputError(folder.string() + ": the scans have the sensor label '" + kLabel +
                             "', but '" + options.sensorLabel + "' is asked for");
        const auto files = listScans(folder);
        const std::size_t frameCount = files.rbegin()->first + 1;
        const auto times = readTimes(folder, frameCount);
        std::vector<mrpt::poses::CPose3D> own;
        if (lookup_.usesInput()) own = readPoses(folder, frameCount);
        for (std::size_t i = 0; i < own.size() && i < times.size(); ++i)
            track_.add(times[i], own[i]);
        for (const auto& [index, file] : files) {
            if (frames_.size() == options.maxScans) break;
            const auto pose = lookup_.pose(
                times[index], lookup_.usesInput() ? std::optional(own[index]) : std::nullopt);
            if (pose.pose)
                frames_.push_back({file, times[index], *pose.pose});
            else
                countWithoutPose(pose, skipped_);
        }
        const auto first = times[files.begin()->first];
        if (frames_.empty())
            throwNoScanHasPose(folder.string(), options, first, times[files.rbegin()->first],
                               lookup_.fromFile());
        PoseSummary summary("poses of the folder", own.size());
        if (!track_.empty()) {
            const auto after = [&](Trajectory::Time time) {
                return std::chrono::duration<double>(time - first).count();
            };
            summary.setTimes(after(track_.firstTime()), after(track_.lastTime()));
        }
        summary_ = lookup_.summary(first, summary);
    }

    std::uint64_t total() const override { return frames_.size(); }
    SkippedObservations skipped() const override { return skipped_; }
    PoseSummary poses() const override { return summary_; }
    const PoseTrack* trajectory() const override {
        return lookup_.usesInput() ? &track_ : lookup_.fromFile();
    }

    std::optional<Scan> next() override {
        if (next_ == frames_.size()) return std::nullopt;
        const Frame& frame = frames_[next_++];
        auto observation = mrpt::obs::CObservationPointCloud::Create();
        observation->sensorLabel = kLabel;
        observation->timestamp = frame.time;
        observation->pointcloud = readPoints(frame.file);
        return Scan{frame.time, frame.T_map_velo, observation};
    }

 private:
    static constexpr const char* kLabel = "VELODYNE";

    struct Frame {
        fs::path file;
        Trajectory::Time time;
        mrpt::poses::CPose3D T_map_velo;
    };

    /// Scan files by frame number, which is their name: row of poses and times.
    static std::map<std::size_t, fs::path> listScans(const fs::path& folder) {
        constexpr std::size_t kMostFrames = 10'000'000;
        std::map<std::size_t, fs::path> files;
        std::error_code error;
        for (const auto& entry : fs::directory_iterator(folder / "velodyne", error)) {
            if (entry.path().extension() != ".bin") continue;
            const std::string name = entry.path().stem().string();
            std::size_t frame = 0;
            const auto [rest, bad] =
                std::from_chars(name.data(), name.data() + name.size(), frame);
            if (bad != std::errc{} || rest != name.data() + name.size() || frame > kMostFrames)
                throw InputError(entry.path().string() + ": is not named by its frame number");
            if (!files.emplace(frame, entry.path()).second)
                throw InputError(entry.path().string() + ": frame " + std::to_string(frame) +
                                 " is there twice, see " + files[frame].string());
        }
        if (files.empty())
            throw InputError(folder.string() +
                             ": is not a KITTI odometry folder: it has no velodyne/*.bin");
        return files;
    }

    static std::vector<Trajectory::Time> readTimes(const fs::path& folder, std::size_t frames) {
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

    static std::vector<mrpt::poses::CPose3D> readPoses(const fs::path& folder,
                                                       std::size_t frames) {
        const Isometry3d T_cam_velo = readCalibration(folder / "calib.txt");
        const fs::path path = findPoses(folder);
        std::vector<mrpt::poses::CPose3D> poses;
        forEachLine(path, [&](const std::string& line, const std::string& where) {
            const Isometry3d T_first_cam = fromRowMajor(numbersOrThrow(line, where), where);
            poses.push_back(toPose(cameraToMap() * T_first_cam * T_cam_velo));
        });
        checkCount(path, "poses", poses.size(), frames);
        return poses;
    }

    static void checkCount(const fs::path& path, const char* what, std::size_t count,
                           std::size_t frames) {
        if (count < frames)
            throw InputError(path.string() + ": has " + std::to_string(count) + " " + what +
                             " for " + std::to_string(frames) + " frames in velodyne/");
    }

    PoseLookup lookup_;
    PoseTrack track_;  // of the folder's own poses
    PoseSummary summary_;
    std::vector<Frame> frames_;
    std::size_t next_ = 0;
    SkippedObservations skipped_;
};

}  // namespace

std::unique_ptr<ScanSource> openKitti(const fs::path& folder,
                                      const ScanSourceOptions& options) {
    return std::make_unique<KittiSource>(folder, options);
}

}  // namespace superray
