// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/img/CImage.h>
#include <mrpt/io/lazy_load_path.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <superray/eval/input_error.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <vector>

#include "sources/object_reader.h"
#include "sources/scan_source_formats.h"

namespace superray {
namespace {

namespace fs = std::filesystem;
using mrpt::obs::CActionCollection;
using mrpt::obs::CObservation;
using mrpt::obs::CSensoryFrame;
using mrpt::poses::CPose3D;
using mrpt::serialization::CSerializable;

/// Odometry and scans are rarely logged at the same instant: how long before
/// the first or after the last pose a scan may be [s].
constexpr double kPoseSlack = 0.05;

/// Calls `visit` for the observations that an object is or holds.
void forEachObservation(const CSerializable::Ptr& object,
                        const std::function<void(const CObservation::Ptr&)>& visit) {
    if (auto observation = std::dynamic_pointer_cast<CObservation>(object)) {
        visit(observation);
    } else if (auto frame = std::dynamic_pointer_cast<CSensoryFrame>(object)) {
        for (const auto& part : *frame) visit(part);
    }
}

/// What the first pass learns.
struct Index {
    Trajectory robotPoses, odometry;
    bool hasActions = false;
    std::vector<Trajectory::Time> scanTimes;
    std::uint64_t objects = 0;  ///< to read in the second pass
    std::string warning;

    /// Poses by time, in order of preference; empty if they come from actions.
    const Trajectory& trajectory() const {
        return robotPoses.empty() && !hasActions ? odometry : robotPoses;
    }
    bool posesFromActions() const { return robotPoses.empty() && hasActions; }
};

class RawlogSource final : public ScanSource {
 public:
    RawlogSource(const std::string& path, const ScanSourceOptions& options)
        : path_(path), options_(options), poses_(options) {
        readIndex();
        if (index_.scanTimes.empty()) throwNoScans(path_, options_, skipped_);
        std::uint64_t posed = 0;
        for (const auto& time : index_.scanTimes) posed += poseAt(time).has_value();
        if (posed == 0) {
            const auto [first, last] =
                std::minmax_element(index_.scanTimes.begin(), index_.scanTimes.end());
            poses_.throwNoScanHasPose(path_, *first, *last, index_.trajectory());
        }
        total_ = std::min(posed, options_.maxScans);
        skipped_ = {};  // counted again as scans are delivered
        reader_ = std::make_unique<ObjectReader>(path_, FileState::whole);
    }

    std::uint64_t total() const override { return total_; }
    SkippedObservations skipped() const override { return skipped_; }
    std::string warning() const override { return index_.warning; }

    const Trajectory* trajectory() const override {
        if (!poses_.usesInput()) return poses_.fromFile();
        return index_.posesFromActions() ? nullptr : &index_.trajectory();
    }

    std::optional<Scan> next() override {
        while (ready_.empty() && reader_->objects() < index_.objects) take(reader_->next());
        if (ready_.empty() || delivered_ == total_) return std::nullopt;
        useExternalsFolder();
        ++delivered_;
        Scan scan = std::move(ready_.front());
        ready_.pop_front();
        return scan;
    }

 private:
    void readIndex() {
        ObjectReader reader(path_, FileState::unknown);
        SkippedObservations ignored;
        try {
            while (auto object = reader.next()) {
                index_.hasActions |= IS_CLASS(*object, CActionCollection);
                forEachObservation(object, [&](const auto& o) { addToIndex(*o); });
                index_.objects = reader.objects();
                if (indexIsEnough()) break;
            }
        } catch (const InputError& e) {
            const std::string message = std::string(e.what()) + "; scans before it: " +
                                        std::to_string(index_.scanTimes.size());
            const bool isTruncated = dynamic_cast<const TruncatedInputError*>(&e) != nullptr;
            if (isTruncated && options_.truncation == Truncation::error)
                throw InputError(message + " (--accept-truncated takes those)");
            if (!isTruncated && options_.truncation == Truncation::accept)
                throw InputError(message +
                                 "; it is damaged, not truncated: nothing of it is certain");
            if (!isTruncated || index_.scanTimes.empty()) throw InputError(message);
            index_.warning = message;
        }
    }

    void addToIndex(const CObservation& observation) {
        using mrpt::obs::CObservationOdometry;
        using mrpt::obs::CObservationRobotPose;
        const bool odometryOnly = options_.poses == PoseOrigin::odometry;
        const auto* p = dynamic_cast<const CObservationRobotPose*>(&observation);
        if (p && !odometryOnly)
            index_.robotPoses.add(p->timestamp, p->pose.mean);
        else if (const auto* o = dynamic_cast<const CObservationOdometry*>(&observation))
            index_.odometry.add(o->timestamp, CPose3D(o->odometry));
        else if (isRangeObservation(observation) &&
                 hasWantedLabel(observation, options_, skipped_))
            index_.scanTimes.push_back(observation.timestamp);
    }

    /// True once the first maxScans scans and the poses around them are known.
    bool indexIsEnough() const {
        if (index_.scanTimes.size() < options_.maxScans) return false;
        if (poses_.usesInput() && index_.posesFromActions()) return true;
        std::uint64_t posed = 0;
        for (const auto& t : index_.scanTimes)
            posed += poses_.pose(t, index_.trajectory().at(t)).has_value();
        return posed >= options_.maxScans;
    }

    std::optional<CPose3D> poseAt(Trajectory::Time time) const {
        std::optional<CPose3D> own;
        if (poses_.usesInput())
            own = index_.posesFromActions() ? T_map_robot_
                                            : index_.trajectory().at(time, kPoseSlack);
        return poses_.pose(time, own);
    }

    void take(const CSerializable::Ptr& object) {
        if (auto actions = std::dynamic_pointer_cast<CActionCollection>(object)) {
            CPose3D increment;
            if (actions->getFirstMovementEstimationMean(increment))
                T_map_robot_ = T_map_robot_ + increment;
        }
        forEachObservation(object, [&](const CObservation::Ptr& o) {
            if (!isRangeObservation(*o) || !hasWantedLabel(*o, options_, skipped_)) return;
            if (const auto pose = poseAt(o->timestamp))
                ready_.push_back({o->timestamp, *pose, o});
            else
                ++skipped_.withoutPose;
        });
    }

    void useExternalsFolder() const {
        fs::path folder = path_;
        while (folder.extension() == ".gz" || folder.extension() == ".rawlog")
            folder.replace_extension();
        folder += "_Images";
        std::error_code error;
        if (!fs::is_directory(folder, error)) return;
        const std::string name = fs::absolute(folder).string();
        mrpt::io::setLazyLoadPathBase(name);
        mrpt::img::CImage::setImagesPathBase(name);
    }

    std::string path_;
    ScanSourceOptions options_;
    PoseLookup poses_;
    Index index_;
    std::uint64_t total_ = 0, delivered_ = 0;
    SkippedObservations skipped_;
    std::unique_ptr<ObjectReader> reader_;
    CPose3D T_map_robot_;  // sum of the actions so far
    std::deque<Scan> ready_;
};

}  // namespace

std::unique_ptr<ScanSource> openRawlog(const std::string& path,
                                       const ScanSourceOptions& options) {
    return std::make_unique<RawlogSource>(path, options);
}

}  // namespace superray
