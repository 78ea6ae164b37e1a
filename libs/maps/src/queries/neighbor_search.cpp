// SPDX-License-Identifier: BSD-3-Clause
#include "queries/neighbor_search.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace superray {
namespace {

bool isNearer(const Neighbor& a, const Neighbor& b) {
    return std::tie(a.squaredDistance, a.id) < std::tie(b.squaredDistance, b.id);
}

template <int Dim>
class NeighborSearch {
 public:
    using Field = DistanceField<Dim>;
    using Blocks = typename Field::OccupiedBlocks;

    NeighborSearch(const CellGeometry<Dim>& geometry, const NeighborQuery& query)
        : geometry_(geometry),
          query_(query),
          axes_(query.distance == NeighborDistance::fromAbove ? 2 : Dim),
          farthest_(query.squaredRadius) {
        if (Dim == 2 && query.distance == NeighborDistance::inSpace)
            height_ = query.point.z() * query.point.z();
    }

    /// Nothing farther than this cell needs to be looked at.
    void limitTo(const Cell<Dim>& cell) {
        farthest_ = std::min(farthest_, neighborAt(cell).squaredDistance);
    }

    void run(const Blocks& blocks) {
        const Point<Dim> p = query_.point.template head<Dim>();
        // From above, the blocks of a column are equally near.
        if (axes_ == Dim && geometry_.contains(p)) {
            findBlocksAround(blocks, blockOf<Dim>(geometry_.cellOf(p)));
        } else {
            for (const auto& [key, mask] : blocks) lookInto(key, mask);
        }
    }

    std::vector<Neighbor> result() && {
        std::sort(found_.begin(), found_.end(), isNearer);
        return std::move(found_);
    }

 private:
    Neighbor neighborAt(const Cell<Dim>& cell) const {
        const Point<Dim> center = geometry_.center(cell);
        Neighbor n;
        n.point = {static_cast<float>(center[0]), static_cast<float>(center[1]),
                   Dim == 3 ? static_cast<float>(center[Dim - 1]) : 0.0f};
        // From the centre itself, not from its rounded coordinates: GCC 12 leaves out the
        // rounding in such code where it vectorises.
        for (int a = 0; a < axes_; ++a) {
            const double gap = center[a] - query_.point[a];
            n.squaredDistance += gap * gap;
        }
        n.squaredDistance += height_;
        for (std::size_t a = 0; a < Dim; ++a)
            n.id |= static_cast<std::uint64_t>(cell[a] + kCellLimit) << (16 * a);
        return n;
    }

    /// At most the squared distance of any point in the block: the points are half a cell
    /// inside it, far more than any rounding.
    double squaredGapTo(const BlockKey<Dim>& key) const {
        const double edge = kBlockEdge * geometry_.resolution();
        const Point<Dim> low = geometry_.lowerCorner(cellInBlock<Dim>(key, 0));
        double sum = height_;
        for (int a = 0; a < axes_; ++a) {
            const double gap =
                std::max({0.0, low[a] - query_.point[a], query_.point[a] - low[a] - edge});
            sum += gap * gap;
        }
        return sum;
    }

    /// The same for all blocks outside the cube of blocks up to `rings` around `centre`.
    double squaredGapOutside(const BlockKey<Dim>& centre, int rings) const {
        const double edge = kBlockEdge * geometry_.resolution();
        const Point<Dim> low = geometry_.lowerCorner(cellInBlock<Dim>(centre, 0));
        double gap = std::numeric_limits<double>::infinity();
        for (int a = 0; a < Dim; ++a) {
            const double inBlock = query_.point[a] - low[a];
            gap = std::min({gap, inBlock + rings * edge, (rings + 1) * edge - inBlock});
        }
        gap = std::max(gap, 0.0);
        return gap * gap + height_;
    }

    void findBlocksAround(const Blocks& blocks, const BlockKey<Dim>& centre) {
        double asked = 0;
        for (int ring = 0;; ++ring) {
            if (ring > 0 && squaredGapOutside(centre, ring - 1) > farthest_) return;
            asked += std::pow(2 * ring + 1, Dim) - std::pow(std::max(0, 2 * ring - 1), Dim);
            if (asked > static_cast<double>(blocks.size())) {
                for (const auto& [key, mask] : blocks)
                    if (ringOf(centre, key) >= ring) lookInto(key, mask);
                return;
            }
            lookIntoRing(blocks, centre, ring);
        }
    }

    static int ringOf(const BlockKey<Dim>& centre, const BlockKey<Dim>& key) {
        int ring = 0;
        for (std::size_t a = 0; a < Dim; ++a)
            ring = std::max<int>(ring, std::abs(key[a] - centre[a]));
        return ring;
    }

    void lookIntoRing(const Blocks& blocks, const BlockKey<Dim>& centre, int ring) {
        Cell<Dim> d;
        d.fill(-ring);
        for (;;) {
            BlockKey<Dim> key;
            for (std::size_t a = 0; a < Dim; ++a) key[a] = centre[a] + d[a];
            if (const auto it = blocks.find(key); it != blocks.end()) lookInto(key, it->second);
            // Along x, only the ends belong to the ring unless another axis is at its end.
            bool atEnd = false;
            for (std::size_t a = 1; a < Dim; ++a) atEnd = atEnd || std::abs(d[a]) == ring;
            std::size_t a = 0;
            while (a < Dim && d[a] == ring) d[a++] = -ring;
            if (a == Dim) return;
            d[a] = a == 0 && !atEnd ? ring : d[a] + 1;
        }
    }

    void lookInto(const BlockKey<Dim>& key, const BlockMask<Dim>& mask) {
        if (squaredGapTo(key) > farthest_) return;
        for (int w = 0; w < BlockMask<Dim>::kWords; ++w)
            for (std::uint64_t bits = mask.words[static_cast<std::size_t>(w)]; bits;
                 bits &= bits - 1)
                offer(neighborAt(cellInBlock<Dim>(key, 64 * w + __builtin_ctzll(bits))));
    }

    void offer(const Neighbor& neighbor) {
        if (!(neighbor.squaredDistance <= farthest_)) return;
        // A heap with the farthest on top, once there are enough.
        if (found_.size() == query_.most) {
            if (!isNearer(neighbor, found_.front())) return;
            std::pop_heap(found_.begin(), found_.end(), isNearer);
            found_.back() = neighbor;
            std::push_heap(found_.begin(), found_.end(), isNearer);
        } else {
            found_.push_back(neighbor);
            if (found_.size() < query_.most) return;
            std::make_heap(found_.begin(), found_.end(), isNearer);
        }
        farthest_ = std::min(farthest_, found_.front().squaredDistance);
    }

    const CellGeometry<Dim>& geometry_;
    const NeighborQuery& query_;
    int axes_;           // of the blocks, that count
    double height_ = 0;  // [m^2] above the plane of a 2D map
    double farthest_;    // [m^2] of what may still be found
    std::vector<Neighbor> found_;
};

}  // namespace

template <int Dim>
std::vector<Neighbor> findNeighbors(DistanceField<Dim>& field,
                                    const typename DistanceField<Dim>::Source& source,
                                    const NeighborQuery& query) {
    using Field = DistanceField<Dim>;
    const auto& geometry = source.map.geometry();
    NeighborSearch<Dim> search(geometry, query);
    const Point<Dim> p = query.point.template head<Dim>();
    const bool sensible = query.most > 0 && query.squaredRadius >= 0 && query.point.allFinite();
    // A single point is as near as the one that the field has for the cell, or nearer.
    if (sensible && query.most == 1 && geometry.contains(p) &&
        (Dim == 2 || query.distance == NeighborDistance::inSpace)) {
        Cell<Dim> cell = geometry.cellOf(p);
        typename Field::Code code;
        field.nearest(source, Field::kNearReach, &cell, 1, &code);
        if (code.found()) {
            for (std::size_t a = 0; a < Dim; ++a) cell[a] += code.offset()[a];
            search.limitTo(cell);
        }
    }
    field.readOccupied(source, [&](const typename Field::OccupiedBlocks& blocks) {
        if (sensible) search.run(blocks);
    });
    return std::move(search).result();
}

template std::vector<Neighbor> findNeighbors<2>(DistanceField<2>&,
                                                const DistanceField<2>::Source&,
                                                const NeighborQuery&);
template std::vector<Neighbor> findNeighbors<3>(DistanceField<3>&,
                                                const DistanceField<3>::Source&,
                                                const NeighborQuery&);

}  // namespace superray
