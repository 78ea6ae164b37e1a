// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/maps/COccupancyGridMap3D.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <superray/eval/input_error.h>

#include <cmath>
#include <limits>

#include "engines/bench_engines.h"

namespace superray {
namespace {

/// One byte a cell, everywhere in the box around the data.
class MrptGrid3dEngine final : public BenchEngine {
 public:
    explicit MrptGrid3dEngine(const BenchEngineOptions& options) {
        const Eigen::Vector3f margin =
            Eigen::Vector3f::Constant(static_cast<float>(2 * options.resolution));
        const Eigen::Vector3f low = options.bounds.min() - margin;
        const Eigen::Vector3f high = options.bounds.max() + margin;
        const double cells = ((high - low) / options.resolution).cast<double>().prod();
        if (!(cells < kMostCells))
            throw InputError("mrpt-grid3d: its map of the box around the data would have " +
                             std::to_string(cells) + " cells; must be less than " +
                             std::to_string(kMostCells));
        map_.setSize({low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()},
                     options.resolution);
        map_.insertionOptions.maxDistanceInsertion = std::numeric_limits<float>::max();
        if (options.peerModel == PeerModel::own) return;
        const SensorProbabilities p;
        map_.insertionOptions.maxOccupancyUpdateCertainty = static_cast<float>(p.probHit);
        map_.insertionOptions.maxFreenessUpdateCertainty = static_cast<float>(1 - p.probMiss);
    }

    void prepare(const PointScan& scan) override {
        points_.clear();
        points_.reserve(scan.points.size());
        for (const Eigen::Vector3f& p : scan.points)
            points_.insertPointFast(p.x(), p.y(), p.z());
        origin_ = {scan.origin.x(), scan.origin.y(), scan.origin.z()};
    }
    void insert() override { map_.insertPointCloud(origin_, points_); }
    std::size_t mapBytes() const override {
        return map_.m_grid.getSizeX() * map_.m_grid.getSizeY() * map_.m_grid.getSizeZ() *
               sizeof(mrpt::maps::COccupancyGridMap3D::voxelType);
    }
    std::optional<double> occupancy(const Eigen::Vector3f& p) const override {
        const float free = map_.getFreenessByPos(p.x(), p.y(), p.z());
        if (free == 0.5f) return std::nullopt;  // never seen, as far as it can tell
        return 1 - double{free};
    }

 private:
    static constexpr double kMostCells = 8e9;
    mrpt::maps::COccupancyGridMap3D map_;
    mrpt::maps::CSimplePointsMap points_;
    mrpt::math::TPoint3D origin_;
};

}  // namespace

void listMrptGrid3dEngine(BenchEngineList& list) {
    list.push_back({"mrpt-grid3d",
                    "MRPT, COccupancyGridMap3D::insertPointCloud() (approximate)", false,
                    "rayByRay", false, [](const BenchEngineOptions& options) {
                        return std::make_unique<MrptGrid3dEngine>(options);
                    }});
}

}  // namespace superray
