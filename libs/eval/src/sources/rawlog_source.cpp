// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <superray/eval/input_error.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "sources/external_folders.h"
#include "sources/object_reader.h"
#include "sources/poses/scan_poses.h"
#include "sources/scan_source_formats.h"

namespace superray {
namespace {

using mrpt::obs::CActionCollection;
using mrpt::obs::CObservation;
using mrpt::obs::CSensoryFrame;
using mrpt::poses::CPose3D;
using mrpt::serialization::CSerializable;

/// Calls `visit` for the observations that an object is or holds.
void forEachObservation(const CSerializable::Ptr& object,
                        const std::function<void(const CObservation::Ptr&)>& visit) {
    if (auto observation = std::dynamic_pointer_cast<CObservation>(object)) {
        visit(observation);
    } else if (auto frame = std::dynamic_pointer_cast<CSensoryFrame>(object)) {
        for (const auto& part : *frame) visit(part);
    }
}

/// Numbers observations, actions and objects as they come: the same in every pass.
class Counter {
 public:
    void nextObject() { ++group_; }
    Place nextEntry(mrpt::Clock::time_point time) { return {time, ++order_, group_}; }

 private:
    std::uint64_t order_ = 0, group_ = 0;
};

/// What the first pass learns.
struct Index {
    RecordedPoses recorded;
    std::uint64_t objects = 0;  ///< to read in the second pass
    std::string warning;
};

/// Tells sensors apart by label and class.
class SensorNumbers {
 public:
    unsigned of(const CObservation& observation) {
        const auto name =
            observation.sensorLabel + "\n" + observation.GetRuntimeClass()->className;
        return numbers_.emplace(name, static_cast<unsigned>(numbers_.size())).first->second;
    }

 private:
    std::map<std::string, unsigned> numbers_;
};

/// How many scans there are of each label.
class LabelCounts {
 public:
    void see(const std::string& label) { ++counts_[label]; }
    std::vector<std::string> labels() const {
        std::vector<std::string> all;
        for (const auto& entry : counts_) all.push_back(entry.first);
        return all;
    }
    /// E.g. "'FRONT' (20), 'REAR' (20)".
    std::string list() const {
        std::string text;
        for (const auto& [label, count] : counts_)
            text += (text.empty() ? "'" : ", '") + label + "' (" + std::to_string(count) + ")";
        return text;
    }

 private:
    std::map<std::string, std::uint64_t> counts_;
};

class RawlogSource final : public ScanSource {
 public:
    RawlogSource(const std::string& path, const ScanSourceOptions& options)
        : path_(path), options_(options), folders_(path) {
        readIndex();
        const auto& scans = index_.recorded.scans;
        if (scans.empty()) throwNoScans(path_, options_, skipped_, labels_.list());
        poses_.emplace(index_.recorded, options_, path_);
        std::uint64_t posed = 0;
        for (const ScanPlace& s : scans) posed += poses_->at(s.place).pose.has_value();
        if (posed == 0) {
            const auto [first, last] = std::minmax_element(
                scans.begin(), scans.end(), [](const ScanPlace& a, const ScanPlace& b) {
                    return a.place.time < b.place.time;
                });
            throwNoScanHasPose(path_, options_, first->place.time, last->place.time,
                               poses_->track());
        }
        total_ = std::min(posed, options_.maxScans);
        skipped_ = {};  // counted again as scans are delivered
        skipped_.badPoses = poses_->notFinite();
        index_.recorded = {};
        reader_ = std::make_unique<ObjectReader>(path_, FileState::whole);
    }

    std::uint64_t total() const override { return total_; }
    SkippedObservations skipped() const override { return skipped_; }
    std::string warning() const override { return index_.warning; }
    const PoseTrack* trajectory() const override { return poses_->track(); }
    PoseSummary poses() const override { return poses_->summary(); }
    std::vector<std::string> sensorLabels() const override { return labels_.labels(); }

    std::optional<Scan> next() override {
        while (ready_.empty() && reader_->objects() < index_.objects) take(reader_->next());
        if (ready_.empty() || delivered_ == total_) return std::nullopt;
        ++delivered_;
        Scan scan = std::move(ready_.front());
        ready_.pop_front();
        findExternalFiles(*scan.observation);
        return scan;
    }

 private:
    void readIndex() {
        ObjectReader reader(path_, FileState::unknown);
        Counter counter;
        try {
            while (auto object = reader.next()) {
                counter.nextObject();
                addActions(*object, counter);
                forEachObservation(object, [&](const CObservation::Ptr& o) {
                    addToIndex(*o, counter.nextEntry(o->timestamp));
                });
                index_.objects = reader.objects();
            }
        } catch (const InputError& e) {
            index_.warning = acceptBreak(e, index_.recorded.scans.size(), options_);
        }
    }

    void findExternalFiles(const CObservation& observation) const {
        try {
            folders_.useFor(observation);
        } catch (const InputError& e) {
            throw InputError(path_ + ": scan " + std::to_string(delivered_) + " (sensor '" +
                             observation.sensorLabel + "') cannot be inserted: " + e.what());
        }
    }

    void addActions(const CSerializable& object, Counter& counter) {
        const auto* actions = dynamic_cast<const CActionCollection*>(&object);
        if (actions == nullptr) return;
        const auto time =
            actions->size() > 0 ? (*actions->begin())->timestamp : mrpt::Clock::time_point();
        const Place place = counter.nextEntry(time);
        CPose3D increment;
        if (!actions->getFirstMovementEstimationMean(increment)) {
            ++index_.recorded.streams.emptyActions;
        } else if (!index_.recorded.streams.addAction(increment, place)) {
            throw InputError(
                path_ + ": the movement of action " +
                std::to_string(index_.recorded.streams.actions.entries.size() + 1) +
                " is not finite: no pose after it is known");
        }
    }

    void addToIndex(const CObservation& observation, const Place& place) {
        index_.recorded.streams.add(observation, place);
        if (isRangeObservation(observation)) labels_.see(observation.sensorLabel);
        if (isRangeObservation(observation) && hasWantedLabel(observation, options_, skipped_))
            index_.recorded.scans.push_back({place, sensors_.of(observation)});
    }

    void take(const CSerializable::Ptr& object) {
        counter_.nextObject();
        if (IS_CLASS(*object, CActionCollection)) counter_.nextEntry({});
        forEachObservation(object, [&](const CObservation::Ptr& o) {
            const Place place = counter_.nextEntry(o->timestamp);
            if (!isRangeObservation(*o) || !hasWantedLabel(*o, options_, skipped_)) return;
            const PoseAnswer answer = poses_->at(place);
            if (answer.pose)
                ready_.push_back({o->timestamp, *answer.pose, o});
            else if (!place.hasTime())
                ++skipped_.withoutTime;
            else
                countWithoutPose(answer, skipped_);
        });
    }

    std::string path_;
    ScanSourceOptions options_;
    ExternalFolders folders_;
    SensorNumbers sensors_;
    LabelCounts labels_;  // of range sensors
    Index index_;
    std::optional<ScanPoses> poses_;  // set from the index
    std::uint64_t total_ = 0, delivered_ = 0;
    SkippedObservations skipped_;
    std::unique_ptr<ObjectReader> reader_;
    Counter counter_;
    std::deque<Scan> ready_;
};

}  // namespace

std::unique_ptr<ScanSource> openRawlog(const std::string& path,
                                       const ScanSourceOptions& options) {
    return std::make_unique<RawlogSource>(path, options);
}

}  // namespace superray
