// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The culling region within one block, from that of the blocks nearer to the sensor.

#include <superray/core/block.h>

#include <array>
#include <cstdint>

namespace superray {

/// The 8 cells of a row along x, one bit each.
using RowBits = std::uint32_t;
constexpr RowBits kFullRow = 0xFF;

/// Ones of `row` reachable from its low end: trailing ones.
inline RowBits upwardRun(RowBits row) {
    return (row ^ (row + 1)) >> 1 & kFullRow;
}
/// Ones of `row` reachable from its high end: leading ones.
inline RowBits downwardRun(RowBits row) {
    const RowBits holes = ~row & kFullRow;
    if (holes == 0) return kFullRow;
    const int highest = 31 - __builtin_clz(holes);
    return kFullRow & ~((RowBits{2} << highest) - 1);
}

template <int Dim>
RowBits rowOf(const BlockMask<Dim>& m, int row) {
    return static_cast<RowBits>(m.words[row >> 3] >> ((row & 7) * 8)) & kFullRow;
}
template <int Dim>
void setRow(BlockMask<Dim>& m, int row, RowBits bits) {
    m.words[row >> 3] |= std::uint64_t{bits} << ((row & 7) * 8);
}

/// A block into which the culling region grows from the sensor's side.
template <int Dim>
class CullingBlock {
 public:
    /// What the region is in the block.
    struct Filled {
        BlockMask<Dim> region;    ///< its cells in the region
        BlockMask<Dim> enclosed;  ///< its cells with all nearer neighbours in the region
    };

    /// `maskOf(key)` is the region in a block that is nearer to the sensor; null: empty.
    template <typename MaskOf>
    CullingBlock(const BlockKey<Dim>& key, const Cell<Dim>& sensor, const MaskOf& maskOf) {
        const BlockKey<Dim> home = blockOf<Dim>(sensor);
        for (int a = 0; a < Dim; ++a) {
            sensor_[a] = sensor[a] & (kBlockEdge - 1);
            side_[a] = (key[a] > home[a]) - (key[a] < home[a]);
            if (side_[a] == 0) continue;
            BlockKey<Dim> nearer = key;
            nearer[a] -= side_[a];
            if (const BlockMask<Dim>* m = maskOf(nearer)) inward_[a] = *m;
        }
    }

    /// Per axis: +1 if the block lies above the sensor's block, -1 below, 0 beside it.
    int side(int axis) const { return side_[axis]; }

    /// \param saturated cells of the block that are saturated free
    Filled fill(const BlockMask<Dim>& saturated) const {
        constexpr int kRows = kBlockCells<Dim> / kBlockEdge;
        Filled filled;
        for (int r = 0; r < kRows; ++r) {
            const int y = coordinate(1, r & (kBlockEdge - 1));
            const int z = Dim == 3 ? coordinate(2, r >> kBlockBits) : 0;
            const int row = y + kBlockEdge * z;
            RowBits enclosed = nearerAcross(filled.region, row, {0, y, z});
            if (enclosed == 0) continue;
            const RowBits run = runAlong(row, enclosed & rowOf<Dim>(saturated, row));
            enclosed &= nearerAlong(row, run);
            setRow<Dim>(filled.region, row, run);
            setRow<Dim>(filled.enclosed, row, enclosed);
        }
        return filled;
    }

 private:
    /// The i-th coordinate of an order in which a row comes after its nearer neighbours:
    /// away from the sensor, and where the sensor is between, first up from it, then down.
    int coordinate(int axis, int i) const {
        if (side_[axis] > 0) return i;
        if (side_[axis] < 0) return kBlockEdge - 1 - i;
        return i < kBlockEdge - sensor_[axis] ? sensor_[axis] + i : kBlockEdge - 1 - i;
    }

    /// Cells of a row whose nearer neighbours along y and z are in the region.
    RowBits nearerAcross(const BlockMask<Dim>& region, int row,
                         const std::array<int, 3>& at) const {
        RowBits nearer = kFullRow;
        for (int a = 1; a < Dim; ++a) {
            const int pitch = a == 1 ? 1 : kBlockEdge;
            const int step =
                side_[a] != 0 ? side_[a] : (at[a] > sensor_[a]) - (at[a] < sensor_[a]);
            if (step == 0) continue;
            const int inner = at[a] - step;
            if (inner >= 0 && inner < kBlockEdge)
                nearer &= rowOf<Dim>(region, row - step * pitch);
            else  // the facing row of the nearer block
                nearer &= rowOf<Dim>(inward_[a], row + step * (kBlockEdge - 1) * pitch);
        }
        return nearer;
    }

    /// The region in a row: those of `open` that are in one run from the sensor's side.
    RowBits runAlong(int row, RowBits open) const {
        if (side_[0] > 0) return carried(row) != 0 ? upwardRun(open) : 0;
        if (side_[0] < 0) return carried(row) != 0 ? downwardRun(open) : 0;
        if ((open & own()) == 0) return 0;
        return (upwardRun(open | below()) & ~below()) |
               (downwardRun(open | above() | own()) & below());
    }

    /// Cells of a row whose nearer neighbour along x is in the region, which is `run` there.
    RowBits nearerAlong(int row, RowBits run) const {
        if (side_[0] > 0) return run << 1 | carried(row);
        if (side_[0] < 0) return run >> 1 | carried(row) << 7;
        return own() | (run << 1 & above()) | (run >> 1 & below());
    }

    /// 1 if the cell before the row's near end is in the region.
    RowBits carried(int row) const {
        const RowBits facing = rowOf<Dim>(inward_[0], row);
        return side_[0] > 0 ? facing >> 7 : facing & 1;
    }

    // Where the sensor is between the ends of a row: its own cell, and those on its sides.
    RowBits own() const { return RowBits{1} << sensor_[0]; }
    RowBits below() const { return own() - 1; }
    RowBits above() const { return kFullRow & ~(own() | below()); }

    std::array<int, 3> side_{};
    std::array<int, 3> sensor_{};  ///< its cell within its block
    /// The region in the nearer block along each axis.
    std::array<BlockMask<Dim>, Dim> inward_{};
};

}  // namespace superray
