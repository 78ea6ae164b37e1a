// SPDX-License-Identifier: BSD-3-Clause
// Scans of ROS recordings: a first pass reads transforms and poses, a second one the scans.

#include "sources/ros/ros_source.h"

#include <superray/eval/input_error.h>
#include <superray/maps/option_text.h>

#include <algorithm>
#include <optional>

#include "sources/poses/scan_poses.h"
#include "sources/ros/robot_frame.h"
#include "sources/ros/ros_contents.h"
#include "sources/scan_source_formats.h"

namespace superray {
namespace {

class RosSource final : public ScanSource {
 public:
    RosSource(const std::string& path, const ScanSourceOptions& options)
        : path_(path), options_(options), contents_(options) {
        readContents();
        if (contents_.scans().empty()) failWithoutScans();
        robot_ = chooseRobotFrame(contents_, options_, path_);
        givePoses();
        recording_ = openRosRecording(path_, FileState::whole);
    }

    std::uint64_t total() const override { return total_; }
    SkippedObservations skipped() const override { return skipped_; }
    std::string warning() const override { return warning_; }
    std::vector<std::string> sensorLabels() const override {
        return contents_.scanTopicNames();
    }
    const PoseTrack* trajectory() const override { return poses_->track(); }
    PoseSummary poses() const override {
        PoseSummary summary = poses_->summary();
        summary.note += (summary.note.empty() ? "" : ", ") + std::string("of the frame '") +
                        robot_.name + "'" + leftOut_;
        return summary;
    }

    std::optional<Scan> next() override {
        while (recording_->messages() < contents_.messages()) {
            const auto message = recording_->next();
            if (!message) break;
            if (!acceptsLabel(options_, recording_->topics().at(message->topic).name)) continue;
            auto scan = contents_.readScan(*recording_, *message, recording_->messages());
            if (!scan) continue;
            const Place place{scan->observation->timestamp, recording_->messages(),
                              recording_->messages()};
            const PoseAnswer mounted = mountAt(scan->frame, place);
            const PoseAnswer answer = mounted.pose ? poses_->at(place) : mounted;
            if (answer.pose) {
                if (delivered_ == total_) return std::nullopt;
                ++delivered_;
                mount(*scan, *mounted.pose);
                return Scan{place.time, *answer.pose, scan->observation};
            }
            if (!place.hasTime())
                ++skipped_.withoutTime;
            else
                countWithoutPose(answer, skipped_);
        }
        return std::nullopt;
    }

 private:
    void readContents() {
        const auto recording = openRosRecording(path_);
        try {
            while (const auto message = recording->next()) contents_.add(*recording, *message);
        } catch (const InputError& e) {
            warning_ = acceptBreak(e, contents_.scans().size(), options_);
        }
    }

    PoseAnswer mountAt(const std::string& frame, const Place& place) const {
        return robot_.mountAt(frame, place.time, poseLimits(options_));
    }

    bool usesRecordedPoses() const {
        return options_.poses != PoseOrigin::file && options_.poses != PoseOrigin::fixed;
    }

    /// Topics that are no poses of the robot must not be asked for; else they are told of.
    void leaveOut(const RosPoses& found) {
        if (!usesRecordedPoses()) return;
        for (const std::string& label : splitList(options_.poseLabel)) {
            const auto none = found.notOfRobot.find(label);
            if (none != found.notOfRobot.end())
                throw InputError(path_ + ": '" + label + "' (--pose-label) " + none->second +
                                 ": it cannot tell where the robot is; choose other poses, " +
                                 "the recording has: " + PoseChooser::list(found.streams));
        }
        for (const auto& [topic, why] : found.notOfRobot)
            leftOut_.append(", without '").append(topic).append("', which ").append(why);
    }

    /// \throws InputError if the poses that were decided on need transforms that contradict
    ///         each other
    void checkTransforms(const RecordedPoses& recorded, const RosPoses& found) const {
        if (!usesRecordedPoses()) return;
        const PoseChooser chooser(recorded.streams, options_, path_);
        const auto check = [&](const std::optional<PoseCandidate>& used) {
            const auto told =
                used ? found.contradictions.find(used->label) : found.contradictions.end();
            if (told != found.contradictions.end())
                throw InputError(path_ + ": " + told->second + ": which of them holds for " +
                                 used->name() +
                                 ", is not known. Cut the recording where that changes, "
                                 "leave out the wrong one, or choose other poses "
                                 "(--pose-label, --poses FILE)");
        };
        const auto robotPoses = chooser.robotPoses();
        check(robotPoses);
        if (!robotPoses || poses_->summary().source != robotPoses->name())
            check(chooser.motion());
    }

    void givePoses() {
        RosPoses found = robotPoses(contents_, robot_.name, poseLimits(options_));
        leaveOut(found);
        const RecordedPoses recorded{std::move(found.streams), contents_.scans()};
        try {
            poses_.emplace(recorded, options_, path_);
        } catch (const InputError& e) {
            if (leftOut_.empty()) throw;
            throw InputError(e.what() + leftOut_);
        }
        checkTransforms(recorded, found);
        std::uint64_t posed = 0;
        for (std::size_t i = 0; i < recorded.scans.size(); ++i) {
            const Place& place = recorded.scans[i].place;
            posed += poses_->at(place).pose && mountAt(*contents_.frameOfScan()[i], place).pose;
        }
        if (posed == 0) failWithoutPoses(recorded, found.unusable);
        total_ = std::min(posed, options_.maxScans);
        skipped_.otherLabel = contents_.skipped().otherLabel;
        skipped_.badPoses = poses_->notFinite() + contents_.badPoses();
    }

    [[noreturn]] void failWithoutScans() const {
        if (contents_.skipped().otherLabel > 0)
            throwNoScans(path_, options_, contents_.skipped(), contents_.scanTopics());
        constexpr std::size_t kListed = 20;
        std::string topics;
        auto unused = contents_.unusedTopics();
        if (unused.size() > kListed) unused.resize(kListed);
        for (const RosTopicCount& t : unused)
            topics += (topics.empty() ? "'" : ", '") + t.name + "' (" + t.type + ")";
        throw InputError(path_ +
                         ": holds no scans (sensor_msgs/PointCloud2, LaserScan, or Image of "
                         "encoding 16UC1 or 32FC1)" +
                         (topics.empty() ? "" : "; it has " + topics));
    }

    [[noreturn]] void failWithoutPoses(const RecordedPoses& recorded,
                                       const std::string& unusable) const {
        const auto [first, last] = std::minmax_element(
            recorded.scans.begin(), recorded.scans.end(),
            [](const ScanPlace& a, const ScanPlace& b) { return a.place.time < b.place.time; });
        if (poses_->track() != nullptr && !poses_->track()->empty())
            throwNoScanHasPose(path_, options_, first->place.time, last->place.time,
                               poses_->track());
        throw InputError(path_ + ": holds no poses of the robot's frame '" + robot_.name +
                         "' that can be used (/tf that moves it, nav_msgs/Odometry, "
                         "geometry_msgs/PoseStamped or PoseWithCovarianceStamped)" +
                         (unusable.empty() ? "" : ": " + unusable) +
                         "; give a poses file (--poses FILE), or say that the robot did not "
                         "move (--fixed-robot)");
    }

    std::string path_;
    ScanSourceOptions options_;
    RosContents contents_;
    RobotFrame robot_;
    std::optional<ScanPoses> poses_;  // set from the contents
    std::string warning_, leftOut_;
    std::uint64_t total_ = 0, delivered_ = 0;
    SkippedObservations skipped_;
    std::unique_ptr<RosRecording> recording_;
};

}  // namespace

std::unique_ptr<ScanSource> openRos(const std::string& path, const ScanSourceOptions& options) {
    return std::make_unique<RosSource>(path, options);
}

}  // namespace superray
