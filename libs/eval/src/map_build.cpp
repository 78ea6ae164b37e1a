// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/stopwatch.h>
#include <superray/eval/input_error.h>
#include <superray/eval/map_build.h>
#include <superray/eval/progress_meter.h>
#include <superray/maps/super_ray_map_interface.h>

#include <algorithm>
#include <sstream>

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

/// A line "  name   number  note", left out if the number is 0.
void addCount(std::ostream& out, const char* name, std::uint64_t number,
              const char* note = "") {
    if (number == 0) return;
    out << "  " << name << formatCount(number) << note << "\n";
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
            if (insert(map, *scan, trajectory, limits, report.scans))
                report.insertion += info.lastInsertion();
            else
                ++report.unusable;
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
    if (report.unusable == report.scans)
        throw InputError("none of the " + std::to_string(report.scans) +
                         " scans could be inserted: no ranges or points, or the map's options "
                         "refuse them");
    return report;
}

std::string describe(const BuildReport& r) {
    const auto& i = r.insertion;
    std::ostringstream out;
    out << "scans      " << formatCount(r.scans) << " in " << formatSeconds(r.totalSeconds)
        << "\n"
        << "rays       " << formatCount(i.rays) << "\n";
    for (const auto& poses : r.poses)
        if (!poses.empty()) out << "poses: " << poses << "\n";
    out << "time       reading " << formatSeconds(r.readSeconds) << ", rays "
        << formatSeconds(i.toRaysSeconds) << ", integration "
        << formatSeconds(i.integrateSeconds) << ", map update " << formatSeconds(i.applySeconds)
        << "\n";
    std::ostringstream skipped;
    addCount(skipped, "scans outside the time of the poses    ", r.skipped.withoutPose);
    addCount(skipped, "scans in a gap between two poses       ", r.skipped.inPoseGap);
    addCount(skipped, "scans without a time stamp             ", r.skipped.withoutTime);
    addCount(skipped, "poses not finite                       ", r.skipped.badPoses);
    addCount(skipped, "scans of another sensor                ", r.skipped.otherLabel);
    addCount(skipped, "scans without usable ranges or points  ", r.unusable);
    addCount(skipped, "points not finite                      ", i.skipped.notFinite);
    addCount(skipped, "points outside the addressable cells   ", i.skipped.outOfRange);
    addCount(skipped, "points nearer than the minimum range   ", i.skipped.tooNear);
    addCount(skipped, "points outside the height band         ", i.outOfHeightBand);
    addCount(skipped, "rays outside the time of the poses     ", i.withoutPose);
    addCount(skipped, "measurements without return            ", i.noReturns);
    out << "left out" << (skipped.str().empty() ? "   nothing\n" : "\n" + skipped.str());
    for (const auto& warning : r.warnings) out << "warning    " << warning << "\n";
    return out.str();
}

}  // namespace superray
