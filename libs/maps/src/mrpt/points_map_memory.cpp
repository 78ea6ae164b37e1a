// SPDX-License-Identifier: BSD-3-Clause
// What the points of a points map take, for the memory bound.

#include <algorithm>
#include <unordered_set>

#include "mrpt/points_map_occupancy.h"

namespace superray {

template <int Dim>
std::size_t CSuperRayPointsMap<Dim>::heldBytes() const {
    return occupancy_->heldBytes();
}

template <int Dim>
std::size_t CSuperRayPointsMap<Dim>::pointBytes() const {
    return pointBytesAtMost(0, 0);
}

template <int Dim>
std::size_t CSuperRayPointsMap<Dim>::pointBytesAtMost(std::size_t points,
                                                      std::size_t blocks) const {
    // A node of the table: next, key, pointer, hash; and what the allocator adds twice.
    constexpr std::size_t kPerBlock =
        sizeof(BlockPoints) + 4 * sizeof(void*) + sizeof(BlockKey<Dim>) + 2 * 2 * sizeof(void*);
    const auto grown = [&](std::size_t size, std::size_t capacity) {
        return size + points <= capacity ? capacity : 2 * (size + points);
    };
    const std::size_t all = blocks_.size() + blocks;
    // Tables grow to somewhat more than double the number of entries.
    const std::size_t buckets =
        all <= blocks_.bucket_count() ? blocks_.bucket_count() : 3 * all;
    std::size_t bytes = all * kPerBlock + buckets * sizeof(void*) +
                        grown(sources_.size(), sources_.capacity()) * sizeof(Source);
    for (const auto* axis : {&m_x, &m_y, &m_z})
        bytes += grown(axis->size(), axis->capacity()) * sizeof((*axis)[0]);
    return bytes;
}

template <int Dim>
std::size_t CSuperRayPointsMap<Dim>::pointBytesWith(
    const typename OccupancyMap<Dim>::WrittenBlocks& written) const {
    std::unordered_set<BlockKey<Dim>, IndexHash> blocks;
    const std::size_t points = forEachNewPoint(written, [&](const Cell<Dim>& cell) {
        const BlockKey<Dim> key = blockOf<Dim>(cell);
        if (blocks_.count(key) == 0) blocks.insert(key);
    });
    return pointBytesAtMost(points, blocks.size());
}

template <int Dim>
std::size_t CSuperRayPointsMap<Dim>::pointBytesOf(const OccupancyMap<Dim>& cells,
                                                  float occupied) const {
    std::size_t points = 0, blocks = 0;
    cells.forEachBlock([&](const BlockView<Dim>& block) {
        const std::size_t before = points;
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            points += block.known.test(i) && block.values[i] >= occupied;
        if (points > before) ++blocks;
    });
    // Those of now go, but vectors keep their room.
    return pointBytesAtMost(points - std::min(points, sources_.size()),
                            blocks - std::min(blocks, blocks_.size()));
}

template std::size_t CSuperRayPointsMap<2>::heldBytes() const;
template std::size_t CSuperRayPointsMap<2>::pointBytes() const;
template std::size_t CSuperRayPointsMap<2>::pointBytesAtMost(std::size_t, std::size_t) const;
template std::size_t CSuperRayPointsMap<2>::pointBytesWith(
    const OccupancyMap<2>::WrittenBlocks&) const;
template std::size_t CSuperRayPointsMap<2>::pointBytesOf(const OccupancyMap<2>&, float) const;
template std::size_t CSuperRayPointsMap<3>::heldBytes() const;
template std::size_t CSuperRayPointsMap<3>::pointBytes() const;
template std::size_t CSuperRayPointsMap<3>::pointBytesAtMost(std::size_t, std::size_t) const;
template std::size_t CSuperRayPointsMap<3>::pointBytesWith(
    const OccupancyMap<3>::WrittenBlocks&) const;
template std::size_t CSuperRayPointsMap<3>::pointBytesOf(const OccupancyMap<3>&, float) const;

}  // namespace superray
