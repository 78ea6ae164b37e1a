// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file octomap_agreement.h
/// Maps the same scans with this library and with liboctomap, ray by ray.

#include <octomap/OcTree.h>
#include <superray/core/block.h>
#include <superray/core/ray_bundle.h>
#include <superray/core/scan_integrator.h>
#include <superray/core/traversal.h>
#include <superray/storage/block_grid.h>

#include <algorithm>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "system/grazing.h"

namespace superray::test {

/// What comparing scans has shown.
struct Agreement {
    std::uint64_t scans = 0, rays = 0;
    std::uint64_t visits = 0;        ///< free cells of all our rays
    std::uint64_t grazedVisits = 0;  ///< (ray, cell) that only one of the two has
    std::uint64_t endVisits = 0;     ///< of those: the ray ends just behind the cell
    std::uint64_t unexplained = 0;   ///< of those: neither a graze nor at the end
    long double farthest = 0;        ///< largest graze, or rest behind the cell [cells]
    std::uint64_t cells = 0;         ///< known cells of the final map
    std::uint64_t grazedCells = 0;   ///< those of a visit that only one of the two has
    /// Known in one map only, or with other bits of the value.
    std::uint64_t differing = 0, differingNotGrazed = 0;
};

/// OctoMap's key 32768 is the cell 0.
inline Cell<3> cellOfKey(const octomap::OcTreeKey& key) {
    return {key[0] - kCellLimit, key[1] - kCellLimit, key[2] - kCellLimit};
}

/// Runs both mappers side by side.
class AgreementCheck {
 public:
    /// A cell within this of a ray may be on either side of it [cells].
    static constexpr long double kGraze = 1e-4L;

    AgreementCheck(double resolution, UpdatePolicy policy)
        : geometry_(resolution), policy_(policy), ours_(geometry_), tree_(resolution) {
        const SensorProbabilities p;
        tree_.setProbHit(p.probHit);
        tree_.setProbMiss(p.probMiss);
        tree_.setClampingThresMin(p.clampMin);
        tree_.setClampingThresMax(p.clampMax);
    }

    /// Both get the same points: rounded to OctoMap's float.
    void insert(const Eigen::Vector3f& origin, const std::vector<Eigen::Vector3f>& points) {
        RayBundle<3> rays(geometry_, origin.cast<double>());
        for (const Eigen::Vector3f& p : points) rays.add(p.cast<double>());
        IntegratorOptions options;
        options.policy = policy_;
        ours_.apply(integrator_.integrate(rays, model_, options, &ours_), model_, policy_);

        const octomap::point3d from(origin.x(), origin.y(), origin.z());
        CellCountMap<3> counts;
        octomap::Pointcloud cloud;
        for (const Eigen::Vector3f& p : points) {
            const octomap::point3d to(p.x(), p.y(), p.z());
            cloud.push_back(to);
            tree_.computeRayKeys(from, to, keys_);
            compareRay(origin.cast<double>(), p.cast<double>());
            if (policy_ == UpdatePolicy::oncePerScan) continue;
            for (const octomap::OcTreeKey& key : keys_) ++counts[cellOfKey(key)].misses;
            ++counts[cellOfKey(tree_.coordToKey(to))].hits;
        }
        if (policy_ == UpdatePolicy::oncePerScan) {
            tree_.insertPointCloud(cloud, from, -1, /*lazy_eval=*/false, /*discretize=*/false);
        } else {
            for (const auto& [cell, count] : counts) {
                float& value = theirs_[cell];
                value = model_.updated(value, count.misses, count.hits, policy_);
            }
        }
        ++result_.scans;
        result_.rays += points.size();
    }

    /// Compares the maps.
    Agreement finish() {
        if (policy_ == UpdatePolicy::oncePerScan) {
            tree_.expand();
            for (auto it = tree_.begin_leafs(); it != tree_.end_leafs(); ++it)
                theirs_[cellOfKey(it.getKey())] = it->getLogOdds();
        }
        const auto differs = [&](const Cell<3>& cell) {
            ++result_.differing;
            if (grazed_.count(cell) == 0) ++result_.differingNotGrazed;
        };
        ours_.forEachBlock([&](const BlockView<3>& block) {
            for (int i = 0; i < kBlockCells<3>; ++i) {
                if (!block.known.test(i)) continue;
                ++result_.cells;
                const Cell<3> cell = cellInBlock<3>(block.key, i);
                const auto other = theirs_.find(cell);
                // Values are never NaN, and a zero is always +0.
                if (other == theirs_.end() || other->second != block.values[i]) differs(cell);
            }
        });
        for (const auto& [cell, value] : theirs_)
            if (!ours_.logOdds(cell)) differs(cell);
        result_.grazedCells = grazed_.size();
        return result_;
    }

 private:
    /// Compares the walk with OctoMap's (keys_) and judges the difference.
    void compareRay(const Point<3>& origin, const Point<3>& end) {
        walked_.clear();
        forEachFreeCell(RayLine<3>(geometry_, origin, end),
                        [&](const Cell<3>& cell) { walked_.push_back(cell); });
        result_.visits += walked_.size();
        const auto sameCell = [](const Cell<3>& cell, const octomap::OcTreeKey& key) {
            return cell == cellOfKey(key);
        };
        if (std::equal(walked_.begin(), walked_.end(), keys_.begin(), keys_.end(), sameCell))
            return;

        std::vector<Cell<3>> theirs, different;
        for (const octomap::OcTreeKey& key : keys_) theirs.push_back(cellOfKey(key));
        std::sort(walked_.begin(), walked_.end());
        std::sort(theirs.begin(), theirs.end());
        std::set_symmetric_difference(walked_.begin(), walked_.end(), theirs.begin(),
                                      theirs.end(), std::back_inserter(different));
        const ScaledRay ray(origin, end, geometry_.resolution());
        for (const Cell<3>& cell : different) {
            const long double depth = std::abs(depthInCell(ray, cell));
            const long double rest = std::abs(lengthAfterCell(ray, cell));
            ++result_.grazedVisits;
            if (rest < depth) ++result_.endVisits;
            result_.farthest = std::max(result_.farthest, std::min(depth, rest));
            if (std::min(depth, rest) < kGraze)
                grazed_.insert(cell);
            else
                ++result_.unexplained;
        }
    }

    CellGeometry<3> geometry_;
    SensorModel model_;
    UpdatePolicy policy_;
    BlockGrid<3> ours_;
    ScanIntegrator<3> integrator_;
    octomap::OcTree tree_;
    octomap::KeyRay keys_;
    std::unordered_map<Cell<3>, float, IndexHash> theirs_;
    std::vector<Cell<3>> walked_;
    std::unordered_set<Cell<3>, IndexHash> grazed_;
    Agreement result_;
};

}  // namespace superray::test
