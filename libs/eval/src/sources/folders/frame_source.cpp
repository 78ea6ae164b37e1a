// SPDX-License-Identifier: BSD-3-Clause
#include "sources/folders/frame_source.h"

#include <superray/eval/input_error.h>
#include <superray/maps/option_text.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <map>
#include <memory>
#include <utility>

#include "sources/folders/kitti_files.h"
#include "sources/read_guard.h"
#include "sources/text_numbers.h"

namespace superray {
namespace {

namespace fs = std::filesystem;
using mrpt::poses::CPose3D;

bool isAllDigits(const std::string& text) {
    return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

/// Like strcmp(), but numbers by their values: whole ones, and fractions behind them.
int compareNames(const std::string& a, const std::string& b) {
    const auto isDigit = [](char c) { return c >= '0' && c <= '9'; };
    std::size_t i = 0, k = 0;
    bool inFraction = false;
    while (i < a.size() && k < b.size()) {
        if (!isDigit(a[i]) || !isDigit(b[k])) {
            if (a[i] != b[k]) return a[i] < b[k] ? -1 : 1;
            inFraction = a[i] == '.' && i > 0 && isDigit(a[i - 1]);
            ++i, ++k;
            continue;
        }
        const auto numberAt = [&](const std::string& name, std::size_t& at) {
            const auto begin = inFraction ? at : name.find_first_not_of('0', at);
            at = std::min(name.find_first_not_of("0123456789", at), name.size());
            return begin < at ? name.substr(begin, at - begin) : std::string();
        };
        const std::string x = numberAt(a, i), y = numberAt(b, k);
        if (!inFraction && x.size() != y.size()) return x.size() < y.size() ? -1 : 1;
        if (x != y) return x < y ? -1 : 1;
        inFraction = false;
    }
    return static_cast<int>(i < a.size()) - static_cast<int>(k < b.size());
}

class FrameSource final : public ScanSource {
 public:
    FrameSource(FrameRecording recording, const ScanSourceOptions& options)
        : recording_(std::move(recording)) {
        if (!acceptsLabel(options, recording_.label))
            throw InputError(recording_.path + ": the scans have the sensor label '" +
                             recording_.label + "', but '" + options.sensorLabel +
                             "' is asked for");
        givePoses(options);
        std::vector<Frame> posed;
        for (Frame& frame : recording_.frames)
            if (frame.T_map_robot && posed.size() < options.maxScans)
                posed.push_back(std::move(frame));
        const auto first = recording_.frames.front().time, last = recording_.frames.back().time;
        if (posed.empty())
            throwNoScanHasPose(recording_.path, options, first, last,
                               track_.empty() ? nullptr : &track_);
        recording_.frames = std::move(posed);
        if (recording_.guarded) startGuard();
    }

    std::uint64_t total() const override { return recording_.frames.size(); }
    SkippedObservations skipped() const override { return skipped_; }
    PoseSummary poses() const override { return summary_; }
    std::string warning() const override { return recording_.warning; }
    std::vector<std::string> sensorLabels() const override {
        auto labels = recording_.otherLabels;
        labels.push_back(recording_.label);
        return labels;
    }
    const PoseTrack* trajectory() const override { return track_.empty() ? nullptr : &track_; }

    std::optional<Scan> next() override {
        if (next_ == recording_.frames.size()) return std::nullopt;
        if (guard_) guard_->next();
        const Frame& frame = recording_.frames[next_++];
        auto observation = recording_.read(frame);
        observation->sensorLabel = recording_.label;
        observation->timestamp = frame.time;
        return Scan{frame.time, *frame.T_map_robot, observation};
    }

 private:
    /// The child has a copy of the frames as they are now.
    void startGuard() {
        std::uint64_t bytes = 0;
        for (const Frame& frame : recording_.frames) {
            std::error_code error;
            const auto size = fs::file_size(frame.file, error);
            if (!error) bytes += size;
        }
        const auto readAhead = [this]() -> ReadGuard::Step {
            return [this, next = std::size_t{0}]() mutable {
                if (next == recording_.frames.size()) return false;
                recording_.read(recording_.frames[next++]);
                return true;
            };
        };
        guard_ = std::make_unique<ReadGuard>(recording_.path, readAhead, bytes);
    }

    void givePoses(const ScanSourceOptions& options) {
        auto& frames = recording_.frames;
        summary_ = recording_.ownPoses;
        if (options.poses == PoseOrigin::fixed) {
            for (Frame& f : frames) f.T_map_robot = CPose3D();
            summary_ = PoseSummary("the robot stays at the map's origin");
        } else if (options.poses == PoseOrigin::file && isKittiPoses(options.posesFile)) {
            giveByRow(readKittiPoses(options.posesFile), options.posesFile);
        } else if (options.poses == PoseOrigin::file) {
            giveByFile(options);
        } else {
            for (const Frame& f : frames)
                if (f.T_map_robot && f.time != Trajectory::Time())
                    track_.add(f.time, *f.T_map_robot);
            for (const Frame& f : frames)
                if (!f.T_map_robot) ++skipped_.withoutPose;
        }
        if (!track_.empty() && frames.front().time != Trajectory::Time()) {
            const auto after = [&](Trajectory::Time time) {
                return secondsBetween(frames.front().time, time);
            };
            summary_.setTimes(after(track_.firstTime()), after(track_.lastTime()));
        }
    }

    void giveByOrder(const std::vector<CPose3D>& poses, const std::string& file) {
        auto& frames = recording_.frames;
        for (std::size_t i = 0; i < frames.size(); ++i) frames[i].T_map_robot = poses[i];
        summarize(poses.size(), file, "paired with the scans by their order");
    }

    void summarize(std::size_t poses, const std::string& file, const char* note) {
        summary_ = PoseSummary("file '" + file + "'", poses);
        summary_.note = note;
    }

    /// Poses without times.
    void giveByRow(const std::vector<CPose3D>& poses, const std::string& file) {
        auto& frames = recording_.frames;
        if (poses.size() == frames.size()) return giveByOrder(poses, file);
        const bool haveRows = std::all_of(frames.begin(), frames.end(), [&](const Frame& f) {
            return f.row && *f.row < poses.size();
        });
        if (!haveRows || poses.size() < frames.size())
            throw InputError(file + ": has " + std::to_string(poses.size()) + " poses for " +
                             std::to_string(frames.size()) + " scans of " + recording_.path +
                             ": without times there must be one for each scan, or files "
                             "numbered 0 to " +
                             std::to_string(poses.size() - 1) + " by their rows");
        for (Frame& f : frames) f.T_map_robot = poses[*f.row];
        summarize(poses.size(), file, "paired with the scans by the numbers of the files");
    }

    void giveByFile(const ScanSourceOptions& options) {
        const Trajectory poses = Trajectory::load(options.posesFile);
        PoseLimits limits;
        limits.maxGap = options.maxPoseGap;
        std::size_t found = 0;
        SkippedObservations missing;
        for (Frame& f : recording_.frames) {
            const PoseAnswer answer = poses.lookUp(f.time, limits);
            f.T_map_robot = answer.pose;
            found += answer.pose.has_value();
            if (!answer.pose) countWithoutPose(answer, missing);
        }
        const bool isOneEach =
            poses.size() == recording_.frames.size() && poses.skippedRows() == 0;
        if (found == 0 && !recording_.isTimed && isOneEach) {
            std::vector<CPose3D> inOrder;
            for (const auto& entry : poses.poses()) inOrder.push_back(entry.second);
            return giveByOrder(inOrder, options.posesFile);
        }
        if (!recording_.isTimed && isOneEach && found < recording_.frames.size())
            throw InputError(
                options.posesFile + ": has a pose for each of the " +
                std::to_string(poses.size()) + " scans of " + recording_.path + ", but only " +
                std::to_string(found) +
                " at the times that the names of the files are taken for (their numbers, in "
                "seconds); give poses without times (12 columns), or times in the names");
        skipped_ = missing;
        skipped_.badPoses = poses.skippedRows();
        track_ = poses;
        summary_ = PoseSummary("file '" + options.posesFile + "'", poses.size());
    }

    FrameRecording recording_;
    PoseTrack track_;
    PoseSummary summary_;
    SkippedObservations skipped_;
    std::unique_ptr<ReadGuard> guard_;
    std::size_t next_ = 0;
};

}  // namespace

std::unique_ptr<ScanSource> makeFrameSource(FrameRecording recording,
                                            const ScanSourceOptions& options) {
    return std::make_unique<FrameSource>(std::move(recording), options);
}

std::optional<Trajectory::Time> timeOfName(const std::string& stem) {
    const auto value = parseNumber(stem);
    if (!value || *value < 0) return std::nullopt;
    if (isAllDigits(stem) && stem.size() == 19) return mrpt::Clock::fromDouble(*value * 1e-9);
    if (isAllDigits(stem) && stem.size() == 16) return mrpt::Clock::fromDouble(*value * 1e-6);
    if (*value > 1e11) return std::nullopt;
    return mrpt::Clock::fromDouble(*value);
}

std::optional<std::size_t> frameNumber(const std::string& stem) {
    constexpr std::size_t kMostFrames = 10'000'000;  // of 10 Hz: 11 days
    std::size_t number = 0;
    const auto [rest, bad] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
    if (bad != std::errc{} || rest != stem.data() + stem.size() || number >= kMostFrames)
        return std::nullopt;
    return number;
}

void addNamedFrames(const std::vector<fs::path>& files, FrameRecording& recording) {
    recording.isTimed = false;
    for (const auto& file : files) {
        const std::string stem = file.stem().string();
        Frame frame;
        frame.file = file;
        frame.row = frameNumber(stem);
        if (const auto time = timeOfName(stem)) {
            frame.time = *time;
            recording.isTimed = recording.isTimed || !frame.row;
        }
        recording.frames.push_back(frame);
    }
}

void refuseTwins(const FrameRecording& recording) {
    std::map<Trajectory::Time, fs::path> byTime;
    std::map<fs::path, fs::path> byName;
    const auto fail = [&](const std::string& same, const fs::path& a, const fs::path& b) {
        throw InputError(recording.path + ": has two scans of one " + same + ": " + a.string() +
                         " and " + b.string());
    };
    for (const Frame& f : recording.frames) {
        const auto named = byName.emplace(fs::path(f.file).replace_extension(), f.file);
        if (f.time != Trajectory::Time()) {
            const auto timed = byTime.emplace(f.time, f.file);
            if (!timed.second) {
                char seconds[40];
                std::snprintf(seconds, sizeof seconds, "%.3f", mrpt::Clock::toDouble(f.time));
                fail(std::string("time, ") + seconds + " s", timed.first->second, f.file);
            }
        }
        if (!named.second) fail("name", named.first->second, f.file);
    }
}

std::vector<fs::path> listFrames(const fs::path& folder,
                                 const std::vector<std::string>& extensions) {
    std::vector<fs::path> files;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
        const std::string extension = entry.path().extension().string();
        if (std::any_of(extensions.begin(), extensions.end(), [&](const std::string& wanted) {
                return equalIgnoringCase(extension, wanted);
            }))
            files.push_back(entry.path());
    }
    std::vector<std::pair<double, fs::path>> numbered;
    for (const auto& file : files) {
        if (const auto number = parseNumber(file.stem().string()))
            numbered.emplace_back(*number, file);
    }
    if (numbered.size() != files.size()) {
        std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
            const int order = compareNames(a.stem().string(), b.stem().string());
            return order != 0 ? order < 0 : a < b;
        });
        return files;
    }
    std::sort(numbered.begin(), numbered.end());
    files.clear();
    for (const auto& [value, file] : numbered) files.push_back(file);
    return files;
}

}  // namespace superray
