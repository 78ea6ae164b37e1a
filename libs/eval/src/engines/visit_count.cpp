// SPDX-License-Identifier: BSD-3-Clause
#include "engines/visit_count.h"

#include <superray/core/super_rays.h>
#include <superray/core/traversal.h>

#include <unordered_set>

namespace superray {
namespace {

/// Remembers the block it was asked for last.
class Saturation {
 public:
    Saturation(const SaturationSource<3>& map, float lowerClamp)
        : map_(map), lowerClamp_(lowerClamp) {}
    bool contains(const Cell<3>& cell) {
        const BlockKey<3> key = blockOf<3>(cell);
        if (!asked_ || key != key_) {
            asked_ = true;
            key_ = key;
            mask_ = map_.saturation(key, lowerClamp_).saturatedFree;
        }
        return mask_.test(indexInBlock<3>(cell));
    }

 private:
    const SaturationSource<3>& map_;
    const float lowerClamp_;
    BlockKey<3> key_{};
    bool asked_ = false;
    BlockMask<3> mask_;
};

}  // namespace

VisitCount countVisits(const PointScan& scan, double resolution, UpdatePolicy policy,
                       std::uint32_t superRayThreshold, const SaturationSource<3>& map) {
    const CellGeometry<3> geometry(resolution);
    RayBundle<3> rays(geometry, scan.origin.cast<double>());
    for (const Eigen::Vector3f& p : scan.points) rays.add(p.cast<double>());
    SuperRayGrouper<3> grouper;
    std::vector<char> represents(rays.size(), 0);
    for (const SuperRay& superRay : grouper.group(rays, superRayThreshold))
        represents[superRay.ray] = 1;

    std::unordered_set<Cell<3>, IndexHash> hits;
    if (policy == UpdatePolicy::netEvidence)
        for (std::size_t i = 0; i < rays.size(); ++i) hits.insert(geometry.cellOf(rays.end(i)));
    const SensorModel model(SensorProbabilities::defaultsOf(policy));
    Saturation saturation(map, model.min());
    VisitCount count;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        std::uint64_t changeable = 0;
        forEachFreeCell(RayLine<3>(geometry, rays.origin(i), rays.end(i)),
                        [&](const Cell<3>& cell) {
                            ++count.all;
                            changeable += !saturation.contains(cell) || hits.count(cell) != 0;
                        });
        count.changeable += changeable;
        if (represents[i]) count.changeableOfSuperRays += changeable;
    }
    return count;
}

}  // namespace superray
