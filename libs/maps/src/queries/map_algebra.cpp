// SPDX-License-Identifier: BSD-3-Clause
#include "queries/map_algebra.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_set>

namespace superray {
namespace {

/// Rotation and shift in the map's dimension.
template <int Dim>
struct RigidMotion {
    Eigen::Matrix<double, Dim, Dim> R;
    Point<Dim> t;

    explicit RigidMotion(const mrpt::poses::CPose3D& pose) {
        const auto& rotation = pose.getRotationMatrix();
        const Eigen::Vector3d shift(pose.x(), pose.y(), pose.z());
        for (int r = 0; r < Dim; ++r)
            for (int c = 0; c < Dim; ++c) R(r, c) = rotation(r, c);
        t = shift.template head<Dim>();
        if (!R.allFinite() || !t.allFinite())
            throw std::invalid_argument("merging maps: the pose must be finite");
        if (Dim == 2 && (pose.z() != 0 || pose.pitch() != 0 || pose.roll() != 0))
            throw std::invalid_argument(
                "merging 2D maps: z, pitch and roll of the pose must be 0; it is " +
                pose.asString());
    }
    Point<Dim> operator()(const Point<Dim>& p) const { return R * p + t; }
    Point<Dim> inverse(const Point<Dim>& p) const { return R.transpose() * (p - t); }
};

/// Blocks of `geometry` that a moved block of another map may touch.
template <int Dim>
void addTouchedBlocks(const BlockKey<Dim>& block, const CellGeometry<Dim>& from,
                      const RigidMotion<Dim>& motion, const CellGeometry<Dim>& geometry,
                      std::unordered_set<BlockKey<Dim>, IndexHash>& touched) {
    Eigen::Array<double, Dim, 1> low, high;
    low.setConstant(std::numeric_limits<double>::infinity());
    high = -low;
    for (int corner = 0; corner < 1 << Dim; ++corner) {
        Point<Dim> p;
        for (int a = 0; a < Dim; ++a)
            p[a] = (block[static_cast<std::size_t>(a)] + ((corner >> a) & 1)) * kBlockEdge *
                   from.resolution();
        const Point<Dim> q = motion(p);
        low = low.min(q.array());
        high = high.max(q.array());
    }
    BlockKey<Dim> first, last;
    const double edge = kBlockEdge * geometry.resolution();
    constexpr double kLimit = kCellLimit / kBlockEdge;
    for (std::size_t a = 0; a < Dim; ++a) {
        // Centres lie half a cell inside: rounding at the borders does not matter.
        const auto axis = static_cast<Eigen::Index>(a);
        const double lowest = std::floor(low[axis] / edge + 1e-6);
        const double highest = std::ceil(high[axis] / edge - 1e-6) - 1;
        if (lowest < -kLimit || highest >= kLimit)
            throw std::invalid_argument(
                "merging maps: cells would leave the addressable range of +-" +
                std::to_string(kCellLimit) + " cells");
        first[a] = static_cast<std::int32_t>(lowest);
        last[a] = std::max(first[a], static_cast<std::int32_t>(highest));
    }
    for (BlockKey<Dim> k = first;;) {
        touched.insert(k);
        std::size_t a = 0;
        for (; a < Dim && k[a] == last[a]; ++a) k[a] = first[a];
        if (a == Dim) break;
        ++k[a];
    }
}

}  // namespace

template <int Dim>
void copyBox(const OccupancyMap<Dim>& from, const MetricBounds& box, OccupancyMap<Dim>& to) {
    const Point<Dim> low = box.lowest.template head<Dim>();
    const Point<Dim> high = box.highest.template head<Dim>();
    for (int a = 0; a < Dim; ++a)
        if (!(low[a] <= high[a]))
            throw std::invalid_argument("box: lowest " + std::to_string(low[a]) +
                                        " must be <= highest " + std::to_string(high[a]));
    const double edge = kBlockEdge * from.geometry().resolution();
    from.forEachBlock([&](const BlockView<Dim>& block) {
        const Point<Dim> corner = from.geometry().lowerCorner(cellInBlock<Dim>(block.key, 0));
        if ((corner.array() > high.array()).any() ||
            (corner.array() + edge < low.array()).any())
            return;
        BlockMask<Dim> inside;
        for (int i = 0; i < kBlockCells<Dim>; ++i) {
            if (!block.known.test(i)) continue;
            const Point<Dim> p = from.geometry().center(cellInBlock<Dim>(block.key, i));
            if ((p.array() >= low.array()).all() && (p.array() <= high.array()).all())
                inside.set(i);
        }
        if (inside.any()) to.setBlock({block.key, block.values, inside});
    });
}

template <int Dim>
std::vector<MergedBlock<Dim>> mergedBlocks(const OccupancyMap<Dim>& to,
                                           const OccupancyMap<Dim>& from,
                                           const mrpt::poses::CPose3D& T_to_from,
                                           const SensorModel& model) {
    const RigidMotion<Dim> motion(T_to_from);
    std::unordered_set<BlockKey<Dim>, IndexHash> touched;
    from.forEachBlock([&](const BlockView<Dim>& block) {
        addTouchedBlocks<Dim>(block.key, from.geometry(), motion, to.geometry(), touched);
    });
    std::vector<MergedBlock<Dim>> merged;
    for (const BlockKey<Dim>& key : touched) {
        MergedBlock<Dim> block{key, {}, {}};
        for (int i = 0; i < kBlockCells<Dim>; ++i) {
            const Point<Dim> p = motion.inverse(to.geometry().center(cellInBlock<Dim>(key, i)));
            if (!from.geometry().contains(p)) continue;
            const auto value = from.logOdds(from.geometry().cellOf(p));
            if (!value) continue;
            block.known.set(i);
            block.values[static_cast<std::size_t>(i)] = *value;
        }
        if (!block.known.any()) continue;
        to.visitBlock(key, [&](const BlockView<Dim>& before) {
            for (int i = 0; i < kBlockCells<Dim>; ++i)
                if (before.known.test(i) && block.known.test(i))
                    block.values[static_cast<std::size_t>(i)] += before.values[i];
        });
        for (float& v : block.values) v = std::clamp(v, model.min(), model.max());
        merged.push_back(block);
    }
    return merged;
}

#define SUPERRAY_INSTANTIATE(Dim)                                                             \
    template void copyBox(const OccupancyMap<Dim>&, const MetricBounds&, OccupancyMap<Dim>&); \
    template std::vector<MergedBlock<Dim>> mergedBlocks(                                      \
        const OccupancyMap<Dim>&, const OccupancyMap<Dim>&, const mrpt::poses::CPose3D&,      \
        const SensorModel&);
SUPERRAY_INSTANTIATE(2)
SUPERRAY_INSTANTIATE(3)
#undef SUPERRAY_INSTANTIATE

}  // namespace superray
