// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/maps/COctoMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>

#include "engines/bench_engines.h"

namespace superray {
namespace {

/// COctoMap does not apply the sensor's pose on the robot to the points of a
/// point cloud (but to the origin): the robot stands where the sensor is, and
/// does not turn. Points are subtracted from and added to the origin in single
/// precision, which moves some of them by a rounding error.
class MrptOctomapEngine final : public BenchEngine {
 public:
    explicit MrptOctomapEngine(const BenchEngineOptions& options) : map_(options.resolution) {
        setSensorModel(map_.insertionOptions, options.peerModel);
    }

    void prepare(const PointScan& scan) override {
        auto points = mrpt::maps::CSimplePointsMap::Create();
        points->reserve(scan.points.size());
        for (const Eigen::Vector3f& p_map : scan.points) {
            const Eigen::Vector3f p = p_map - scan.origin;
            points->insertPointFast(p.x(), p.y(), p.z());
        }
        observation_.pointcloud = points;
        robotPose_ = mrpt::poses::CPose3D(scan.origin.x(), scan.origin.y(), scan.origin.z());
    }
    void insert() override { map_.insertObservation(observation_, robotPose_); }
    std::size_t mapBytes() const override { return map_.memoryUsage(); }
    std::optional<double> occupancy(const Eigen::Vector3f& p) const override {
        double probability = 0;
        if (!map_.getPointOccupancy(p.x(), p.y(), p.z(), probability)) return std::nullopt;
        return probability;
    }

 private:
    mrpt::maps::COctoMap map_;
    mrpt::obs::CObservationPointCloud observation_;
    mrpt::poses::CPose3D robotPose_;
};

}  // namespace

void listMrptOctomapEngine(BenchEngineList& list) {
    list.push_back({"mrpt-octomap", "MRPT, COctoMap::insertObservation()", false, "oncePerScan",
                    false, [](const BenchEngineOptions& options) {
                        return std::make_unique<MrptOctomapEngine>(options);
                    }});
}

}  // namespace superray
