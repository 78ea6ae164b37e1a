// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/world_truth.h>
#include <superray/maps/CSuperRayGridMap3D.h>

#include <unordered_map>

namespace superray {
namespace {

using Counts = std::vector<std::uint32_t>;
using CountsOfBlocks = std::unordered_map<BlockKey<3>, Counts, IndexHash>;

CountsOfBlocks countEnds(const CellGeometry<3>& geometry, const std::vector<PointScan>& scans) {
    CountsOfBlocks counts;
    for (const PointScan& scan : scans)
        for (const Eigen::Vector3f& p : scan.points) {
            const Point<3> point = p.cast<double>();
            if (!geometry.contains(point)) continue;
            const Cell<3> cell = geometry.cellOf(point);
            Counts& block = counts[blockOf<3>(cell)];
            if (block.empty()) block.resize(kBlockCells<3>, 0);
            ++block[static_cast<std::size_t>(indexInBlock<3>(cell))];
        }
    return counts;
}

/// A map of which only the set of known cells matters.
CSuperRayGridMap3D mapOf(double resolution, const std::vector<PointScan>& scans) {
    CSuperRayGridMap3D map(resolution);
    map.insertionOptions.setPolicy(UpdatePolicy::everyRay);
    RayBundle<3> rays{CellGeometry<3>(resolution), Point<3>::Zero()};
    for (const PointScan& scan : scans) {
        rays.restart(scan.origin.cast<double>());
        rays.addReturns(scan.points.data()->data(), scan.points.size(), 1);
        map.insertRays(rays);
    }
    return map;
}

double ratio(std::uint64_t a, std::uint64_t b) {
    return b == 0 ? 0 : static_cast<double>(a) / static_cast<double>(b);
}

}  // namespace

double TruthScore::iou() const {
    return ratio(occupiedSolid, occupiedSolid + occupiedFree + missed);
}
double TruthScore::completeness() const {
    return ratio(seenPointsKept, seenPoints);
}
double TruthScore::cellCompleteness() const {
    return seenCells == 0 ? 0 : 1 - ratio(missed, seenCells);
}
double TruthScore::freeSaidOccupied() const {
    return ratio(occupiedFree, knownFree);
}

WorldTruth::WorldTruth(const SimulatedWorld& world, double resolution,
                       const std::vector<PointScan>& inserted,
                       const std::vector<PointScan>& exact)
    : geometry_(resolution) {
    CountsOfBlocks ends = countEnds(geometry_, exact);
    const CSuperRayGridMap3D map = mapOf(resolution, inserted);
    std::unordered_map<BlockKey<3>, BlockMask<3>, IndexHash> known;
    map.storage().forEachBlock(
        [&](const BlockView<3>& block) { known[block.key] = block.known; });
    for (const auto& [key, counts] : ends) known[key];  // noise may leave a block out
    blocks_.reserve(known.size());
    for (const auto& [key, mask] : known) {
        Block block{key, mask, {}, {}};
        const Point<3> low = geometry_.lowerCorner(cellInBlock<3>(key, 0));
        const auto touched = world.touchedParts(
            {low, low + Point<3>::Constant(kBlockEdge * resolution)}, kBlockEdge);
        for (int i = 0; i < kBlockCells<3>; ++i)
            if (touched[static_cast<std::size_t>(i)]) block.solid.set(i);
        if (const auto found = ends.find(key); found != ends.end()) {
            block.seen = std::move(found->second);
            for (int i = 0; i < kBlockCells<3>; ++i)
                if (block.seen[static_cast<std::size_t>(i)] > 0) {
                    block.known.set(i);
                    block.solid.set(i);  // the surface, up to the rounding of float32
                }
        }
        blocks_.push_back(std::move(block));
    }
}

void WorldTruth::forEachCell(const std::function<void(const TrueCell&)>& visit) const {
    for (const Block& block : blocks_)
        for (int i = 0; i < kBlockCells<3>; ++i)
            if (block.known.test(i))
                visit({cellInBlock<3>(block.key, i), block.solid.test(i),
                       block.seen.empty() ? 0 : block.seen[static_cast<std::size_t>(i)]});
}

TruthScore WorldTruth::score(const BenchEngine& engine) const {
    TruthScore score;
    forEachCell([&](const TrueCell& cell) {
        const auto p = engine.occupancy(geometry_.center(cell.cell).cast<float>());
        const bool occupied = p && *p >= kOccupiedFrom;
        score.seenPoints += cell.seen;
        score.seenCells += cell.seen > 0;
        if (occupied) {
            ++(cell.solid ? score.occupiedSolid : score.occupiedFree);
            score.seenPointsKept += cell.seen;
        } else {
            score.missed += cell.seen > 0;
        }
        score.knownFree += p && !cell.solid;
    });
    return score;
}

}  // namespace superray
