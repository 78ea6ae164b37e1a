// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/stopwatch.h>
#include <superray/eval/input_error.h>
#include <superray/eval/map_build.h>
#include <superray/eval/progress_meter.h>
#include <superray/maps/observation_rays.h>
#include <superray/maps/super_ray_map_interface.h>

#include <algorithm>

namespace superray {
namespace {

/// \param trajectory of the robot while it scanned; nullptr: it stood still
bool insert(mrpt::maps::CMetricMap& map, const Scan& scan, const PoseTrack* trajectory,
            const PoseLimits& limits, std::uint64_t number) {
    try {
        if (trajectory)
            return dynamic_cast<SuperRayMapInterface&>(map).insertObservationAlong(
                *scan.observation,
                [&](mrpt::Clock::time_point time) { return trajectory->at(time, limits); });
        return map.insertObservation(*scan.observation, scan.T_map_robot);
    } catch (const std::exception& e) {
        throw InputError("scan " + std::to_string(number) + " (sensor '" +
                         scan.observation->sensorLabel +
                         "') cannot be inserted: " + oneLineCause(e));
    }
}

/// Counts a scan that changed nothing.
void countLeftOut(const mrpt::obs::CObservation& observation, const TInsertionReport& last,
                  BuildReport& report) {
    if (last.tilted > 0) {
        ++report.tiltedScans;
        return;
    }
    ++report.unusable;
    if (report.unreadable.empty()) report.unreadable = whyUnreadable(observation);
}

/// E.g. "12 not finite, 3 nearer than minrange"; empty if there are none.
std::string pointsLeftOut(const TInsertionReport& report) {
    std::string text;
    const auto add = [&](std::uint64_t number, const char* what) {
        if (number == 0) return;
        text += (text.empty() ? "" : ", ") + std::to_string(number) + " " + what;
    };
    add(report.skipped.notFinite, "not finite");
    add(report.skipped.outOfRange, "beyond the cells that can be addressed (32768 each way)");
    add(report.skipped.tooNear, "nearer than minrange");
    add(report.outOfHeightBand, "outside the height band");
    add(report.withoutPose, "measured where no pose is known");
    add(report.noReturns, "without a return");
    return text;
}

std::string whyNothing(const BuildReport& report) {
    if (report.tiltedScans > 0)
        return "planar scans tilted by more than horizontalTolerance, which a 2D map leaves "
               "out";
    if (!report.unreadable.empty()) return report.unreadable;
    const std::string leftOut = pointsLeftOut(report.insertion);
    if (!leftOut.empty()) return "all of their points are left out, " + leftOut;
    return "no ranges or points, or the map's options refuse them";
}

}  // namespace

BuildReport buildMap(const ScanSources& sources, mrpt::maps::CMetricMap& map,
                     std::uint64_t maxScans,
                     const std::function<void(const BuildProgress&)>& onScan,
                     ScanMotion motion) {
    const auto& info = dynamic_cast<const SuperRayMapInterface&>(map);
    BuildReport report;
    BuildProgress progress;
    for (const auto& source : sources) progress.totalScans += source->total();
    progress.totalScans = std::min(progress.totalScans, maxScans);

    const Stopwatch total;
    for (const auto& source : sources) {
        const bool moving = motion == ScanMotion::alongTrajectory;
        const PoseTrack* trajectory = moving ? source->trajectory() : nullptr;
        PoseLimits limits;
        limits.maxGap = source->maxPoseGap();
        report.poses.push_back(source->poses().asText());
        if (moving && !trajectory)
            throw InputError(
                "de-skewing needs robot poses by time, which an input with poses " +
                source->poses().asText() + " does not have; give a poses file (--poses FILE)");
        while (report.scans < maxScans) {
            const Stopwatch reading;
            const auto scan = source->next();
            report.readSeconds += reading.seconds();
            if (!scan) break;
            ++report.scans;
            const bool inserted = insert(map, *scan, trajectory, limits, report.scans);
            report.insertion += info.lastInsertion();
            if (!inserted) countLeftOut(*scan->observation, info.lastInsertion(), report);
            progress.scans = report.scans;
            progress.rays = report.insertion.rays;
            progress.seconds = total.seconds();
            onScan(progress);
        }
        report.skipped += source->skipped();
        if (const auto warning = source->warning(); !warning.empty())
            report.warnings.push_back(warning);
    }
    report.totalSeconds = total.seconds();
    if (motion == ScanMotion::alongTrajectory && report.insertion.timedRays == 0)
        report.warnings.push_back(
            "nothing was de-skewed: no scan tells when its points were measured (raw Velodyne "
            "packets do, and 2D scans with sweepDuration)");
    if (!report.unreadable.empty()) report.warnings.push_back(report.unreadable);
    if (report.unusable + report.tiltedScans == report.scans)
        throw InputError("none of the " + std::to_string(report.scans) +
                         " scans could be inserted: " + whyNothing(report));
    return report;
}

}  // namespace superray
