// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <superray/core/stopwatch.h>
#include <superray/eval/input_error.h>
#include <superray/eval/point_scan.h>
#include <superray/eval/soak.h>
#include <superray/maps/map_factory.h>
#include <superray/maps/super_ray_map_interface.h>

#include <algorithm>
#include <cmath>
#include <ostream>

#include "engines/peak_memory.h"

namespace superray {
namespace {

using mrpt::obs::CObservationPointCloud;
using mrpt::poses::CPose3D;

/// The scans as observations whose sensor is at the robot, without rotation.
struct Laps {
    struct Place {
        CObservationPointCloud::Ptr scan;
        Eigen::Vector3d position;
    };
    std::vector<Place> places;
    Eigen::Vector3d step;  ///< from a lap to the next one
    double mostLaps;       ///< from the first one, to either side

    /// Where the robot is at insertion i.
    CPose3D pose(std::uint64_t i) const {
        const std::uint64_t laps = i / places.size();
        const auto lap = static_cast<double>(laps);
        // To one side, to the other one, and back to the start.
        const double phase = std::fmod(lap + mostLaps, 4 * mostLaps);
        const double side = phase <= 2 * mostLaps ? phase - mostLaps : 3 * mostLaps - phase;
        const Eigen::Vector3d p = places[i % places.size()].position + side * step;
        return {p.x(), p.y(), p.z(), 0, 0, 0};
    }
};

CObservationPointCloud::Ptr observationOf(const PointScan& scan, std::size_t most) {
    auto cloud = mrpt::maps::CSimplePointsMap::Create();
    const std::size_t all = scan.points.size();
    const std::size_t count = most == 0 ? all : std::min(most, all);
    cloud->reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const Eigen::Vector3f p = scan.points[i * all / count] - scan.origin;
        cloud->insertPointFast(p.x(), p.y(), p.z());
    }
    auto observation = CObservationPointCloud::Create();
    observation->sensorLabel = "SOAK";
    observation->pointcloud = cloud;
    return observation;
}

Laps lapsOf(const PointScans& scans, const SoakRequest& request) {
    Laps laps;
    for (const PointScan& scan : scans.scans)
        laps.places.push_back(
            {observationOf(scan, request.pointsPerScan), scan.origin.cast<double>()});
    const Eigen::Vector3d way = laps.places.back().position - laps.places.front().position;
    const Eigen::Vector3d extent = (scans.bounds.max() - scans.bounds.min()).cast<double>();
    laps.step = way * (1 + 1.0 / static_cast<double>(laps.places.size()));
    laps.step.z() = 0;
    // A drive that ends near its start, or a sensor that stands still: beside it.
    if (laps.step.norm() < extent.norm() / 20)
        laps.step = {extent.x() / 2 + request.windowRadius, 0, 0};
    const double reach =
        0.9 * kCellLimit * request.resolution -
        scans.bounds.min().cwiseAbs().cwiseMax(scans.bounds.max().cwiseAbs()).maxCoeff();
    laps.mostLaps = std::floor(reach / laps.step.norm());
    if (laps.mostLaps < 1)
        throw InputError(request.data + ": too large to be driven along twice with cells of " +
                         metresText(request.resolution));
    return laps;
}

/// What is asked of a map, in the options that it has.
void setOptions(TMapOptions& options, const SoakRequest& request) {
    options.creation.resolution = request.resolution;
    options.creation.max_memory_megabytes = request.maxMemoryMegabytes;
    options.insertion.windowRadius = request.windowRadius;
    options.insertion.threads = request.threads;
}

SoakRun runClass(const SoakRequest& request, const Laps& laps, const std::string& className,
                 ProgressMeter& meter) {
    const auto map = createMap(className);
    auto& cells = dynamic_cast<SuperRayMapInterface&>(*map);
    TMapOptions options = cells.options();
    setOptions(options, request);
    options.likelihood.decimation = 20;
    cells.setOptions(options);

    SoakRun run;
    run.className = className;
    const Stopwatch total;
    Stopwatch sinceSample;
    BuildProgress progress;
    progress.totalScans = request.insertions;
    CPose3D last = laps.pose(0);
    for (std::uint64_t i = 0; i < request.insertions; ++i) {
        const Laps::Place& place = laps.places[i % laps.places.size()];
        const CPose3D pose = laps.pose(i);
        map->computeObservationLikelihood(*place.scan, pose);
        map->insertObservation(*place.scan, pose);
        run.kilometres += pose.distanceTo(last) / 1000;
        last = pose;
        progress.scans = i + 1;
        progress.rays = cells.totals().rays;
        progress.seconds = total.seconds();
        meter.update(progress);
        const std::uint64_t due = request.insertions * (run.samples.size() + 1) / kSoakSamples;
        if (i + 1 != due) continue;
        const std::uint64_t since =
            i + 1 - (run.samples.empty() ? 0 : run.samples.back().scans);
        run.samples.push_back({i + 1, static_cast<double>(since) / sinceSample.lap(),
                               cells.heldBytes(), residentBytes()});
    }
    run.seconds = total.seconds();
    run.scans = cells.totals().scans;
    run.forgottenBlocks = cells.totals().forgottenBlocks;
    return run;
}

}  // namespace

void SoakRequest::validate() const {
    if (insertions < kSoakSamples)
        throw InputError("insertions: " + std::to_string(insertions) +
                         "; must be >= " + std::to_string(kSoakSamples));
    if (classes.empty()) throw InputError("no classes of maps given");
    for (const std::string& name : classes) createMap(name);
    TMapOptions options;
    setOptions(options, *this);
    options.creation.validate();
    options.insertion.validate();
}

bool isFlat(const std::vector<std::uint64_t>& values, std::uint64_t slack) {
    if (values.size() <= kSoakFilled + 1) return false;
    const auto begin = values.begin() + kSoakFilled;
    const auto middle = begin + (values.end() - begin) / 2;
    const std::uint64_t earlier = *std::max_element(begin, middle);
    const std::uint64_t later = *std::max_element(middle, values.end());
    return later <= earlier + earlier / 20 + slack;
}

bool isFlat(const SoakRun& run) {
    std::vector<std::uint64_t> held, resident;
    for (const SoakSample& s : run.samples) {
        held.push_back(s.heldBytes);
        resident.push_back(s.residentBytes);
    }
    constexpr std::uint64_t kMebi = std::uint64_t{1} << 20;
    return isFlat(held, 0) && isFlat(resident, 4 * kMebi);
}

std::vector<SoakRun> runSoak(const SoakRequest& request, std::ostream& log,
                             ProgressMeter::Style style) {
    request.validate();
    const Laps laps =
        lapsOf(loadPointScans({request.data, request.source, request.worldSeed}), request);
    std::vector<SoakRun> runs;
    for (const std::string& name : request.classes) {
        log << name << std::endl;
        ProgressMeter meter(log, style);
        runs.push_back(runClass(request, laps, name, meter));
    }
    return runs;
}

}  // namespace superray
