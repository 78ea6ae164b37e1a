// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/mrpt_compat.h>

#include "engines/bench_engines.h"

#if SUPERRAY_HAS_MRPT_VOXEL_MAP
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/maps/CVoxelMap.h>

#include <limits>
#endif

namespace superray {

#if SUPERRAY_HAS_MRPT_VOXEL_MAP
namespace {

/// A sparse grid of Bonxai with one byte a cell, in steps of 1/16 of log-odds. Every
/// ray is walked in fixed point, so it may leave the cells that it passes through. A
/// cell past a clamping threshold jumps to the end of the byte.
class MrptVoxelMapEngine final : public BenchEngine {
 public:
    explicit MrptVoxelMapEngine(const BenchEngineOptions& options) : map_(options.resolution) {
        if (options.peerModel == PeerModel::own) return;
        const SensorProbabilities p;
        map_.insertionOptions.prob_hit = p.probHit;
        // It takes the probability of being free; below 0.5 a miss is the smallest step.
        map_.insertionOptions.prob_miss = 1 - p.probMiss;
        map_.insertionOptions.clamp_min = p.clampMin;
        map_.insertionOptions.clamp_max = p.clampMax;
    }

    void prepare(const PointScan& scan) override {
        points_.clear();
        points_.reserve(scan.points.size());
        for (const Eigen::Vector3f& p : scan.points)
            points_.insertPointFast(p.x(), p.y(), p.z());
        origin_ = {scan.origin.x(), scan.origin.y(), scan.origin.z()};
    }
    void insert() override { map_.insertPointCloudAsRays(points_, origin_); }
    std::size_t mapBytes() const override { return map_.grid().memUsage(); }
    std::optional<double> occupancy(const Eigen::Vector3f& p) const override {
        double probability = std::numeric_limits<double>::quiet_NaN();
        if (!map_.getPointOccupancy(p.x(), p.y(), p.z(), probability)) return std::nullopt;
        return probability;
    }

 private:
    mrpt::maps::CVoxelMap map_;
    mrpt::maps::CSimplePointsMap points_;
    mrpt::math::TPoint3D origin_;
};

}  // namespace

void listMrptVoxelMapEngine(BenchEngineList& list) {
    list.push_back({"mrpt-voxelmap", "MRPT, CVoxelMap::insertPointCloudAsRays() (approximate)",
                    false, "rayByRay", false, [](const BenchEngineOptions& options) {
                        return std::make_unique<MrptVoxelMapEngine>(options);
                    }});
}
#else
void listMrptVoxelMapEngine(BenchEngineList&) {}
#endif

}  // namespace superray
