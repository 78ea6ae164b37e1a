// SPDX-License-Identifier: BSD-3-Clause
#include "engines/visit_count.h"

#include <superray/core/super_rays.h>
#include <superray/core/traversal.h>

namespace superray {
namespace {

/// Remembers the block it was asked for last.
class Saturation {
 public:
    explicit Saturation(const SaturationSource<3>& map) : map_(map) {}
    bool contains(const Cell<3>& cell) {
        const BlockKey<3> key = blockOf<3>(cell);
        if (!asked_ || key != key_) {
            asked_ = true;
            key_ = key;
            mask_ = map_.saturation(key, SensorModel().min()).saturatedFree;
        }
        return mask_.test(indexInBlock<3>(cell));
    }

 private:
    const SaturationSource<3>& map_;
    BlockKey<3> key_{};
    bool asked_ = false;
    BlockMask<3> mask_;
};

}  // namespace

VisitCount countVisits(const PointScan& scan, double resolution,
                       std::uint32_t superRayThreshold, const SaturationSource<3>& map) {
    const CellGeometry<3> geometry(resolution);
    RayBundle<3> rays(geometry, scan.origin.cast<double>());
    for (const Eigen::Vector3f& p : scan.points) rays.add(p.cast<double>());
    SuperRayGrouper<3> grouper;
    std::vector<char> represents(rays.size(), 0);
    for (const SuperRay& superRay : grouper.group(rays, superRayThreshold))
        represents[superRay.ray] = 1;

    Saturation saturation(map);
    VisitCount count;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        std::uint64_t changeable = 0;
        forEachFreeCell(RayLine<3>(geometry, rays.origin(i), rays.end(i)),
                        [&](const Cell<3>& cell) {
                            ++count.all;
                            changeable += !saturation.contains(cell);
                        });
        count.changeable += changeable;
        if (represents[i]) count.changeableOfSuperRays += changeable;
    }
    return count;
}

}  // namespace superray
