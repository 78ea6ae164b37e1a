// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Observations for the tests of libs/maps.

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/obs/CRawlog.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/system/os.h>
#include <superray/maps/map_factory.h>
#include <superray/maps/super_ray_map_interface.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace superray::test {

/// A data set of Debian's mrpt-common.
inline std::string mrptDataset(const std::string& name) {
    return mrpt::system::find_mrpt_shared_dir() + "datasets/" + name;
}

/// A folder that goes away with the test.
class TempFolder {
 public:
    TempFolder() {
        std::string pattern =
            (std::filesystem::temp_directory_path() / "superray-XXXXXX").string();
        if (!mkdtemp(pattern.data())) throw std::runtime_error("mkdtemp failed");
        path_ = pattern;
    }
    ~TempFolder() { std::filesystem::remove_all(path_); }
    TempFolder(const TempFolder&) = delete;
    std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
    std::string path_;
};

/// Robot pose and sensor pose, all six coordinates non-zero.
inline mrpt::poses::CPose3D someRobotPose() {
    return {1.5, -2.25, 0.75, 0.8, -0.15, 0.1};
}
inline mrpt::poses::CPose3D someSensorPose() {
    return {0.2, -0.1, 1.1, -0.4, 0.25, -0.2};
}

/// The first scan of a rawlog (with the pose before it, if any).
struct PosedScan {
    mrpt::poses::CPose3D robotPose;
    mrpt::obs::CObservation::Ptr scan;
};
inline std::vector<PosedScan> readScans(const std::string& rawlog, std::size_t count) {
    mrpt::obs::CRawlog log;
    if (!log.loadFromRawLogFile(rawlog)) throw std::runtime_error("cannot read " + rawlog);
    std::vector<PosedScan> scans;
    mrpt::poses::CPose3D pose;
    for (std::size_t i = 0; i < log.size() && scans.size() < count; ++i) {
        if (log.getType(i) != mrpt::obs::CRawlog::etObservation) continue;
        const auto o = log.getAsObservation(i);
        if (const auto p = std::dynamic_pointer_cast<mrpt::obs::CObservationRobotPose>(o)) {
            pose = p->pose.mean;
        } else {
            scans.push_back({pose, o});
        }
    }
    return scans;
}

/// Points at random in a shell around the sensor, in its frame.
inline mrpt::obs::CObservationPointCloud::Ptr randomCloud(std::size_t points, unsigned seed,
                                                          double nearest = 1,
                                                          double farthest = 4) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> uniform(-1, 1), radius(nearest, farthest);
    auto cloud = mrpt::maps::CSimplePointsMap::Create();
    while (cloud->size() < points) {
        Eigen::Vector3d p(uniform(generator), uniform(generator), uniform(generator));
        if (p.norm() < 0.1 || p.norm() > 1) continue;
        p *= radius(generator) / p.norm();
        cloud->insertPoint(static_cast<float>(p.x()), static_cast<float>(p.y()),
                           static_cast<float>(p.z()));
    }
    auto scan = mrpt::obs::CObservationPointCloud::Create();
    scan->pointcloud = cloud;
    scan->sensorPose = someSensorPose();
    scan->sensorLabel = "CLOUD";
    return scan;
}

/// 90 degrees of ranges, half of them invalid.
inline mrpt::obs::CObservation2DRangeScan::Ptr planarScan(std::size_t rays = 91) {
    auto scan = mrpt::obs::CObservation2DRangeScan::Create();
    scan->aperture = static_cast<float>(M_PI / 2);
    scan->maxRange = 20;
    scan->sensorLabel = "LASER";
    scan->sensorPose = mrpt::poses::CPose3D(0.3, 0.1, 0.4, 0.2, 0, 0);
    scan->resizeScanAndAssign(rays, 3.0f, true);
    for (std::size_t i = 0; i < rays; i += 2) {
        scan->setScanRange(i, 0);
        scan->setScanRangeValidity(i, false);
    }
    return scan;
}

inline SuperRayMapInterface& interfaceOf(mrpt::maps::CMetricMap& map) {
    return dynamic_cast<SuperRayMapInterface&>(map);
}
inline const SuperRayMapInterface& interfaceOf(const mrpt::maps::CMetricMap& map) {
    return dynamic_cast<const SuperRayMapInterface&>(map);
}

/// Options of which none has its default value.
inline TMapOptions unusualOptions() {
    TMapOptions o;
    o.creation.resolution = 1.0 / 7;  // not representable in few decimals
    o.creation.reserve_megabytes = 3;
    o.creation.max_memory_megabytes = 77;
    o.creation.enableSaveAs3DObject = false;
    o.creation.enableObservationLikelihood = false;
    o.creation.enableObservationInsertion = false;
    o.insertion.maxrange = 12.3;
    o.insertion.minrange = 0.1;
    o.insertion.probHit = 0.65;
    o.insertion.probMiss = 0.45;
    o.insertion.scanHitMax = 0.88;
    o.insertion.scanMissMin = 0.31;
    o.insertion.clampingThresMin = 0.2;
    o.insertion.clampingThresMax = 0.93;
    o.insertion.occupancyThres = 0.6;
    o.insertion.policy = UpdatePolicy::oncePerScan;
    o.insertion.method = Method::culling;
    o.insertion.superRayThreshold = 5;
    o.insertion.threads = 2;
    o.insertion.decimation = 3;
    o.insertion.insertNoReturnRays = true;
    o.insertion.noReturnRange = 2.5;
    o.insertion.sweepDuration = 0.0375;
    o.insertion.sensorLabel = "CLOUD, other label";
    o.insertion.horizontalTolerance = 12.5;
    o.insertion.clearAtMaxrange = true;
    o.insertion.heightBandMin = -1.0 / 3;
    o.insertion.heightBandMax = 1.7;
    o.insertion.windowRadius = 250.5;
    o.insertion.pointStatistics = true;
    o.likelihood.decimation = 4;
    o.likelihood.sigma = 0.07;
    o.likelihood.maxDistance = 0.21;
    o.likelihood.uniformWeight = 0.15;
    o.likelihood.unknownLikelihood = 0.3;
    o.rendering.generateGridLines = true;
    o.rendering.generateOccupiedVoxels = false;
    o.rendering.visibleOccupiedVoxels = false;
    o.rendering.generateFreeVoxels = true;
    o.rendering.visibleFreeVoxels = false;
    o.rendering.colour = VoxelColour::occupancy;
    return o;
}

/// The message of the exception that f throws; empty if none.
template <class F>
std::string messageOf(F f) {
    try {
        f();
    } catch (const std::exception& e) {
        return e.what();
    }
    return {};
}

#define EXPECT_CONTAINS(text, part) \
    EXPECT_NE((text).find(part), std::string::npos) << "in: " << (text)

#define SUPERRAY_SKIP_WITHOUT(file)                          \
    if (!std::filesystem::exists(file)) {                    \
        GTEST_SKIP() << "SKIPPED, no test data: " << (file); \
    }

}  // namespace superray::test
