#include <mrpt/img/CImage.h>
#include <mrpt/io/lazy_load_path.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CRawlog.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>
#include <superray/eval/input_error.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <vector>

#include "sources/gz_input.h"
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

/// The objects of a rawlog one by one.
class ObjectReader {
 public:
    explicit ObjectReader(const std::string& path)
        : path_(path), file_(path), archive_(mrpt::serialization::archiveFrom(file_)) {}

    /// nullptr at the end. \throws InputError
    CSerializable::Ptr next() {
        while (pending_.empty()) {
            if (file_.atEnd()) {
                if (!file_.error().empty()) fail(file_.error());
                return nullptr;
            }
            expand(read());
        }
        auto object = pending_.front();
        pending_.pop_front();
        ++objects_;
        return object;
    }

    std::uint64_t objects() const { return objects_; }

 private:
    CSerializable::Ptr read() {
        try {
            return archive_.ReadObject();
        } catch (const std::exception& e) {
            if (!file_.error().empty()) fail(file_.error());
            if (objects_ == 0 && !file_.atEnd())
                throw InputError(path_ + ": is not a rawlog (" + oneLineCause(e) + ")");
            fail(file_.atEnd() ? "the file ends inside an object" : oneLineCause(e));
        }
    }

    [[noreturn]] void fail(const std::string& why) const {
        throw InputError(path_ + ": " + why + ", after " + std::to_string(objects_) +
                         " whole objects, at byte " + std::to_string(file_.fileOffset()) +
                         " of " + std::to_string(file_.fileSize()));
    }

    /// A file may be one CRawlog object instead of a sequence.
    void expand(const CSerializable::Ptr& object) {
        if (auto rawlog = std::dynamic_pointer_cast<mrpt::obs::CRawlog>(object))
            for (const auto& entry : *rawlog) pending_.push_back(entry);
        else
            pending_.push_back(object);
    }

    std::string path_;
    GzInput file_;
    decltype(mrpt::serialization::archiveFrom(std::declval<GzInput&>())) archive_;
    std::deque<CSerializable::Ptr> pending_;
    std::uint64_t objects_ = 0;
};

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
        reader_ = std::make_unique<ObjectReader>(path_);
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
        ObjectReader reader(path_);
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
            if (options_.truncation == Truncation::error || index_.scanTimes.empty())
                throw InputError(message);
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
