// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <superray/eval/input_error.h>
#include <superray/maps/options.h>

#include <cstdio>

#include "sources/scan_source_formats.h"

namespace superray {
namespace {

namespace fs = std::filesystem;

bool endsWith(const std::string& text, const std::string& end) {
    return text.size() >= end.size() &&
           text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::string asSeconds(Trajectory::Time time) {
    char text[40];
    std::snprintf(text, sizeof text, "%.3f", mrpt::Clock::toDouble(time));
    return text;
}

}  // namespace

bool isRangeObservation(const mrpt::obs::CObservation& observation) {
    using namespace mrpt::obs;
    return IS_CLASS(observation, CObservation2DRangeScan) ||
           IS_CLASS(observation, CObservation3DRangeScan) ||
           IS_CLASS(observation, CObservationVelodyneScan) ||
           IS_CLASS(observation, CObservationPointCloud) ||
           IS_CLASS(observation, CObservationRotatingScan);
}

bool acceptsLabel(const ScanSourceOptions& options, const std::string& label) {
    TInsertionOptions filter;
    filter.sensorLabel = options.sensorLabel;
    return filter.acceptsSensor(label);
}

bool hasWantedLabel(const mrpt::obs::CObservation& observation,
                    const ScanSourceOptions& options, SkippedObservations& skipped) {
    if (acceptsLabel(options, observation.sensorLabel)) return true;
    ++skipped.otherLabel;
    return false;
}

PoseLookup::PoseLookup(const ScanSourceOptions& options)
    : origin_(options.poses), file_(options.posesFile) {
    if (origin_ == PoseOrigin::file) trajectory_ = Trajectory::load(file_);
}

std::optional<mrpt::poses::CPose3D> PoseLookup::pose(
    Trajectory::Time time, const std::optional<mrpt::poses::CPose3D>& fromInput) const {
    switch (origin_) {
        case PoseOrigin::file:
            return trajectory_.at(time);
        case PoseOrigin::fixed:
            return mrpt::poses::CPose3D();
        case PoseOrigin::input:
        case PoseOrigin::odometry:
            break;
    }
    return fromInput;
}

void PoseLookup::throwNoScanHasPose(const std::string& path, Trajectory::Time firstScan,
                                    Trajectory::Time lastScan,
                                    const Trajectory& inputPoses) const {
    const Trajectory& poses = usesInput() ? inputPoses : trajectory_;
    if (poses.empty())
        throw InputError(path +
                         ": holds no robot poses (CObservationRobotPose, actions or odometry); "
                         "give a poses file (--poses FILE), or say that the robot did not move "
                         "(--fixed-robot)");
    throw InputError(
        (usesInput() ? path : file_) + ": no pose is at the time of a scan: poses " +
        asSeconds(poses.firstTime()) + " to " + asSeconds(poses.lastTime()) + " s, scans of " +
        path + " " + asSeconds(firstScan) + " to " + asSeconds(lastScan) + " s");
}

void throwNoScans(const std::string& path, const ScanSourceOptions& options,
                  const SkippedObservations& skipped) {
    if (skipped.otherLabel > 0)
        throw InputError(path + ": none of its " + std::to_string(skipped.otherLabel) +
                         " scans has the sensor label '" + options.sensorLabel + "'");
    throw InputError(path +
                     ": holds no scans (laser, depth, Velodyne or point-cloud "
                     "observations)");
}

std::unique_ptr<ScanSource> openScanSource(const std::string& path,
                                           const ScanSourceOptions& options) {
    if (options.maxScans == 0) throw InputError("the number of scans must be at least 1");
    std::error_code error;
    if (!fs::exists(path, error)) throw InputError(path + ": no such file or folder");
    const bool isRawlog = endsWith(path, ".rawlog") || endsWith(path, ".rawlog.gz");
    if (options.poses == PoseOrigin::odometry && !isRawlog)
        throw InputError(path + ": has no odometry (rawlogs may have)");
    if (fs::is_directory(path, error)) return openKitti(path, options);
    if (endsWith(path, ".simplemap") || endsWith(path, ".simplemap.gz"))
        return openSimpleMap(path, options);
    if (endsWith(path, ".graph")) return openScanGraph(path, options);
    if (isRawlog) return openRawlog(path, options);
    throw InputError(path +
                     ": unknown input; known are .rawlog, .simplemap, .graph (OctoMap) and "
                     "KITTI odometry folders");
}

}  // namespace superray
