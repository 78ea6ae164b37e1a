// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/poses/CPose3DPDFParticles.h>
#include <mrpt/poses/CPose3DPDFSOG.h>
#include <superray/eval/input_error.h>
#include <superray/maps/mrpt_compat.h>
#include <superray/maps/newer_objects.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "sources/object_reader.h"
#include "sources/poses/pose_streams.h"
#include "sources/scan_source_formats.h"

namespace superray {
namespace {

mrpt::maps::CSimpleMap readSimpleMap(const std::string& path) {
    const auto file = openInput(path);
    mrpt::maps::CSimpleMap map;
    std::string why;
    try {
        const auto object = readObject(*file);
        if (!IS_CLASS(*object, mrpt::maps::CSimpleMap))
            throw std::runtime_error("it is a " +
                                     std::string(object->GetRuntimeClass()->className));
        map = dynamic_cast<const mrpt::maps::CSimpleMap&>(*object);
        // The end of the compressed data holds their check sum.
        if (!file->atEnd()) why = "other data follow it";
        if (!file->error().empty()) why = file->error();
    } catch (const std::exception& e) {
        why = readFailure(*file, e);
    }
    if (!why.empty())
        throw InputError(path + ": is not a whole simplemap: " + why + ", at byte " +
                         std::to_string(file->getPosition()) + bytesOf(*file));
    return map;
}

/// The same after a child process could do it.
mrpt::maps::CSimpleMap readGuarded(const std::string& path) {
    ReadGuard guard(path, [&path]() -> ReadGuard::Step {
        return [&path] {
            readSimpleMap(path);
            return false;
        };
    });
    guard.next();
    return readSimpleMap(path);
}

/// True for a distribution that says nothing: its mean is the origin.
bool isEmpty(const mrpt::poses::CPose3DPDF& pose) {
    using namespace mrpt::poses;
    if (const auto* particles = dynamic_cast<const CPose3DPDFParticles*>(&pose))
        return particles->particlesCount() == 0;
    if (const auto* sum = dynamic_cast<const CPose3DPDFSOG*>(&pose)) return sum->empty();
    return false;
}

/// The mean; nothing if it is not known or not finite.
std::optional<mrpt::poses::CPose3D> poseOf(const mrpt::poses::CPose3DPDF& distribution) {
    if (isEmpty(distribution)) return std::nullopt;
    const mrpt::poses::CPose3D mean = distribution.getMeanVal();
    if (!isFinite(mean)) return std::nullopt;
    return mean;
}

class SimpleMapSource final : public ScanSource {
 public:
    SimpleMapSource(const std::string& path, const ScanSourceOptions& options)
        : poses_(options) {
        const auto map = readGuarded(path);
        findLabels(map);
        std::vector<Trajectory::Time> times;
        for (std::size_t i = 0; i < map.size() && scans_.size() < options.maxScans; ++i) {
            const auto [posePdf, frame] = keyFrameParts(map, i);
            if (!posePdf || !frame)
                throw InputError(path + ": keyframe " + std::to_string(i) +
                                 " lacks its pose or its observations");
            const auto T_map_robot = poseOf(*posePdf);
            skipped_.badPoses += !T_map_robot;
            for (const auto& observation : *frame) {
                if (!observation)
                    throw InputError(path + ": keyframe " + std::to_string(i) +
                                     " holds what is no observation");
                if (!isRangeObservation(*observation) ||
                    !hasWantedLabel(*observation, options, skipped_))
                    continue;
                times.push_back(observation->timestamp);
                const auto pose = poses_.pose(observation->timestamp, T_map_robot);
                if (!pose.pose)
                    countWithoutPose(pose, skipped_);
                else if (scans_.size() < options.maxScans)
                    scans_.push_back({observation->timestamp, *pose.pose, observation});
            }
        }
        if (times.empty()) throwNoScans(path, options, skipped_);
        const auto [first, last] = std::minmax_element(times.begin(), times.end());
        if (scans_.empty()) throwNoScanHasPose(path, options, *first, *last, poses_.fromFile());
        summary_ = poses_.summary(*first, PoseSummary("key frames", map.size()));
    }

    std::uint64_t total() const override { return scans_.size(); }
    SkippedObservations skipped() const override { return skipped_; }
    const PoseTrack* trajectory() const override { return poses_.fromFile(); }
    PoseSummary poses() const override { return summary_; }
    std::vector<std::string> sensorLabels() const override { return labels_; }

    std::optional<Scan> next() override {
        if (next_ == scans_.size()) return std::nullopt;
        return std::move(scans_[next_++]);
    }

 private:
    /// Of all key frames, also of those beyond the last that is asked for.
    void findLabels(const mrpt::maps::CSimpleMap& map) {
        for (std::size_t i = 0; i < map.size(); ++i) {
            const auto frame = keyFrameParts(map, i).observations;
            if (!frame) continue;
            for (const auto& observation : *frame)
                if (observation && isRangeObservation(*observation))
                    labels_.push_back(observation->sensorLabel);
        }
    }

    PoseLookup poses_;
    PoseSummary summary_;
    std::vector<std::string> labels_;
    std::vector<Scan> scans_;
    std::size_t next_ = 0;
    SkippedObservations skipped_;
};

}  // namespace

std::unique_ptr<ScanSource> openSimpleMap(const std::string& path,
                                          const ScanSourceOptions& options) {
    return std::make_unique<SimpleMapSource>(path, options);
}

}  // namespace superray
