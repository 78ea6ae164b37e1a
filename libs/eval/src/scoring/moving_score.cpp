// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/block.h>
#include <superray/eval/moving_score.h>

#include <iterator>
#include <unordered_map>
#include <unordered_set>

namespace superray {
namespace {

using Cells = std::unordered_set<Cell<3>, IndexHash>;

class Observer {
 public:
    Observer(const SimulatedWorld& world, double resolution, const BenchEngine& engine)
        : world_(world), geometry_(resolution), engine_(engine) {}

    /// Right after a scan was inserted.
    void look(std::size_t scan, const PointScan& inserted, const PointScan& exact) {
        lastScan_ = scan;
        std::unordered_map<Cell<3>, std::uint64_t, IndexHash> raysOfWalker;
        for (std::size_t i = 0; i < inserted.points.size(); ++i) {
            const auto kind = world_.kindOfSurface(exact.points[i].cast<double>(), scan);
            if (kind == SolidKind::fixed) continue;
            const Cell<3> cell = geometry_.cellOf(inserted.points[i].cast<double>());
            if (world_.touchesFixed(boxOf(cell))) continue;
            if (kind == SolidKind::walker)
                ++raysOfWalker[cell];
            else
                box_.insert(cell);
        }
        for (const auto& [cell, rays] : raysOfWalker)
            if (walker_.insert(cell).second) {
                const bool detected = occupied(cell);
                ++score_.walkerCells;
                score_.detected += detected;
                score_.walkerRays += rays;
                score_.detectedRays += detected ? rays : 0;
            }
        if (scan + 1 == world_.removalScan()) keepOccupied();
        if (scan >= world_.removalScan() && !score_.scansToHalf && score_.boxCells > 0 &&
            2 * countOccupied(box_) <= score_.boxCells)
            score_.scansToHalf = scan + 1 - world_.removalScan();
    }

    MovingScore score() const {
        MovingScore score = score_;
        for (const Cell<3>& cell : walker_)
            score.ghosts += occupied(cell) && !world_.touches(boxOf(cell), lastScan_);
        return score;
    }

 private:
    Eigen::AlignedBox3d boxOf(const Cell<3>& cell) const {
        const Point<3> low = geometry_.lowerCorner(cell);
        return {low, low + Point<3>::Constant(geometry_.resolution())};
    }
    bool occupied(const Cell<3>& cell) const {
        const auto p = engine_.occupancy(geometry_.center(cell).cast<float>());
        return p && *p >= kOccupiedFrom;
    }
    std::uint64_t countOccupied(const Cells& cells) const {
        std::uint64_t count = 0;
        for (const Cell<3>& cell : cells) count += occupied(cell);
        return count;
    }
    /// From now on the box is gone.
    void keepOccupied() {
        for (auto cell = box_.begin(); cell != box_.end();)
            cell = occupied(*cell) ? std::next(cell) : box_.erase(cell);
        score_.boxCells = box_.size();
    }

    const SimulatedWorld& world_;
    CellGeometry<3> geometry_;
    const BenchEngine& engine_;
    Cells walker_, box_;  // cells in which rays that met them ended, so far
    MovingScore score_;
    std::size_t lastScan_ = 0;
};

}  // namespace

MovingScore scoreMoving(const SimulatedWorld& world, double resolution,
                        const std::vector<PointScan>& inserted,
                        const std::vector<PointScan>& exact, BenchEngine& engine) {
    Observer observer(world, resolution, engine);
    for (std::size_t i = 0; i < inserted.size(); ++i) {
        engine.prepare(inserted[i]);
        engine.insert();
        observer.look(i, inserted[i], exact[i]);
    }
    return observer.score();
}

}  // namespace superray
