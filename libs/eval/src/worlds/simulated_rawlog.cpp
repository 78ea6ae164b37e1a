// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/poses/CPose3DQuat.h>
#include <mrpt/serialization/CArchive.h>
#include <superray/eval/simulated_rawlog.h>
#include <superray/maps/gzip_output.h>
#include <superray/storage/atomic_file.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

namespace superray {
namespace {

namespace fs = std::filesystem;

constexpr double kFirstScanTime = 1.5e9;  // [s since 1970]

mrpt::obs::CObservationRobotPose poseObservation(const SimulatedScan& scan,
                                                 mrpt::Clock::time_point time) {
    mrpt::obs::CObservationRobotPose observation;
    observation.timestamp = time;
    observation.sensorLabel = "POSE";
    observation.pose.mean = scan.T_map_robot;
    return observation;
}

mrpt::obs::CObservationPointCloud cloudObservation(const SimulatedScan& scan,
                                                   mrpt::Clock::time_point time) {
    mrpt::obs::CObservationPointCloud observation;
    observation.timestamp = time;
    observation.sensorLabel = "SIMULATED";
    observation.sensorPose = scan.T_robot_sensor;
    auto cloud = mrpt::maps::CSimplePointsMap::Create();
    cloud->reserve(scan.points.size());
    for (const Eigen::Vector3f& p : scan.points) cloud->insertPointFast(p.x(), p.y(), p.z());
    observation.pointcloud = cloud;
    return observation;
}

std::string tumLine(const SimulatedScan& scan) {
    const mrpt::poses::CPose3DQuat p(scan.T_map_robot);
    char line[320];
    std::snprintf(line, sizeof line, "%.6f %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n",
                  kFirstScanTime + scan.seconds, p.x(), p.y(), p.z(), p.quat().x(),
                  p.quat().y(), p.quat().z(), p.quat().r());
    return line;
}

}  // namespace

void writeSimulatedRawlog(const SimulatedWorld& world, std::uint64_t scans,
                          const std::string& path, const LoadProgress& progress) {
    GzipOutput rawlog(path);
    AtomicStream tum(fs::path(path).replace_extension(".tum").string());
    auto archive = mrpt::serialization::archiveFrom(rawlog);
    const auto total = std::min<std::uint64_t>(scans, world.scanCount());
    for (std::uint64_t i = 0; i < total; ++i) {
        const SimulatedScan scan = world.scan(i);
        const auto time = mrpt::Clock::fromDouble(kFirstScanTime + scan.seconds);
        archive << poseObservation(scan, time) << cloudObservation(scan, time);
        tum << tumLine(scan);
        if (progress) progress(i + 1, total);
    }
    tum.commit();
    rawlog.commit();
}

}  // namespace superray
