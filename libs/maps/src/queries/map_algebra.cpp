// SPDX-License-Identifier: BSD-3-Clause
#include "queries/map_algebra.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_set>
#include <utility>

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

/// Blocks from `first` to `last`, both included.
template <int Dim>
struct BlockRange {
    BlockKey<Dim> first, last;

    template <class Visit>
    void forEach(const Visit& visit) const {
        for (BlockKey<Dim> k = first;;) {
            visit(k);
            std::size_t a = 0;
            for (; a < Dim && k[a] == last[a]; ++a) k[a] = first[a];
            if (a == Dim) break;
            ++k[a];
        }
    }
};

/// Blocks of `geometry` that a moved cube of another map may touch.
/// \param corner the lowest one
template <int Dim>
BlockRange<Dim> touchedBlocks(const Point<Dim>& corner, double edge,
                              const RigidMotion<Dim>& motion,
                              const CellGeometry<Dim>& geometry) {
    Eigen::Array<double, Dim, 1> low, high;
    low.setConstant(std::numeric_limits<double>::infinity());
    high = -low;
    for (int c = 0; c < 1 << Dim; ++c) {
        Point<Dim> p = corner;
        for (int a = 0; a < Dim; ++a) p[a] += ((c >> a) & 1) * edge;
        const Point<Dim> q = motion(p);
        low = low.min(q.array());
        high = high.max(q.array());
    }
    BlockRange<Dim> touched;
    const double blockEdge = kBlockEdge * geometry.resolution();
    constexpr std::int32_t kLimit = kCellLimit / kBlockEdge;  // [blocks]
    for (std::size_t a = 0; a < Dim; ++a) {
        // Centres lie half a cell inside: rounding at the borders does not matter.
        const auto axis = static_cast<Eigen::Index>(a);
        const double lowest = std::floor(low[axis] / blockEdge + 1e-6);
        const double highest = std::ceil(high[axis] / blockEdge - 1e-6) - 1;
        if (lowest < -kLimit || highest >= kLimit)
            throw std::invalid_argument(
                "merging maps: cells would leave the addressable range of +-" +
                std::to_string(kCellLimit) + " cells");
        touched.first[a] = static_cast<std::int32_t>(lowest);
        touched.last[a] = std::max(touched.first[a], static_cast<std::int32_t>(highest));
    }
    return touched;
}

template <int Dim>
class Merger {
 public:
    Merger(const OccupancyMap<Dim>& to, const OccupancyMap<Dim>& from,
           const mrpt::poses::CPose3D& T_to_from, const SensorModel& model,
           const MergeCheck<Dim>& check)
        : to_(to), from_(from), motion_(T_to_from), model_(model), check_(check) {}

    MergedBlocks<Dim> run() && {
        // All of them first: the error is the same whatever memory there is.
        from_.forEachBlock([&](const BlockView<Dim>& block) { rangeOf(block); });
        from_.forEachBlock([&](const BlockView<Dim>& block) { addBlock(block); });
        if (!merged_.empty()) check_(merged_, workingBytes());
        return std::move(merged_);
    }

 private:
    BlockRange<Dim> rangeOf(const BlockView<Dim>& block) const {
        return touchedBlocks<Dim>(from_.geometry().lowerCorner(cellInBlock<Dim>(block.key, 0)),
                                  kBlockEdge * from_.geometry().resolution(), motion_,
                                  to_.geometry());
    }

    void addBlock(const BlockView<Dim>& block) {
        const auto addKey = [&](const BlockKey<Dim>& key) { add(key); };
        const double edge = from_.geometry().resolution();
        if (to_.geometry().resolution() >= edge) return rangeOf(block).forEach(addKey);
        // A block may touch a great many finer ones, of which its known cells touch few.
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (block.known.test(i))
                touchedBlocks<Dim>(from_.geometry().lowerCorner(cellInBlock<Dim>(block.key, i)),
                                   edge, motion_, to_.geometry())
                    .forEach(addKey);
    }

    /// What a block of `to` becomes, once.
    void add(const BlockKey<Dim>& key) {
        if (!touched_.insert(key).second) return;
        MergedBlock<Dim> block{key, {}, {}};
        for (int i = 0; i < kBlockCells<Dim>; ++i) {
            const Point<Dim> p =
                motion_.inverse(to_.geometry().center(cellInBlock<Dim>(key, i)));
            if (!from_.geometry().contains(p)) continue;
            const auto value = from_.logOdds(from_.geometry().cellOf(p));
            if (!value) continue;
            block.known.set(i);
            block.values[static_cast<std::size_t>(i)] = *value;
        }
        if (block.known.any()) {
            to_.visitBlock(key, [&](const BlockView<Dim>& before) {
                for (int i = 0; i < kBlockCells<Dim>; ++i)
                    if (before.known.test(i) && block.known.test(i))
                        block.values[static_cast<std::size_t>(i)] += before.values[i];
            });
            for (float& v : block.values) v = std::clamp(v, model_.min(), model_.max());
            merged_.push_back(block);
        }
        if (workingBytes() < nextCheck_) return;
        check_(merged_, workingBytes());
        nextCheck_ = workingBytes() / 8 * 9;
    }

    std::size_t workingBytes() const {
        // A node of the table: next, key, hash, and its pointer; what the allocator adds.
        constexpr std::size_t kPerKey = sizeof(BlockKey<Dim>) + 5 * sizeof(void*);
        return merged_.size() * sizeof(MergedBlock<Dim>) + touched_.size() * kPerKey;
    }

    const OccupancyMap<Dim>&to_, &from_;
    RigidMotion<Dim> motion_;
    const SensorModel& model_;
    const MergeCheck<Dim>& check_;
    std::unordered_set<BlockKey<Dim>, IndexHash> touched_;
    MergedBlocks<Dim> merged_;
    std::size_t nextCheck_ = std::size_t{1} << 17;  // [bytes]
};

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
MergedBlocks<Dim> mergedBlocks(const OccupancyMap<Dim>& to, const OccupancyMap<Dim>& from,
                               const mrpt::poses::CPose3D& T_to_from, const SensorModel& model,
                               const MergeCheck<Dim>& check) {
    return Merger<Dim>(to, from, T_to_from, model, check).run();
}

#define SUPERRAY_INSTANTIATE(Dim)                                                             \
    template void copyBox(const OccupancyMap<Dim>&, const MetricBounds&, OccupancyMap<Dim>&); \
    template MergedBlocks<Dim> mergedBlocks(                                                  \
        const OccupancyMap<Dim>&, const OccupancyMap<Dim>&, const mrpt::poses::CPose3D&,      \
        const SensorModel&, const MergeCheck<Dim>&);
SUPERRAY_INSTANTIATE(2)
SUPERRAY_INSTANTIATE(3)
#undef SUPERRAY_INSTANTIATE

}  // namespace superray
