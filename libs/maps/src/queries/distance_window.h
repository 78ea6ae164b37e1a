// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file distance_window.h
/// Exact distances for one block of a DistanceField.

#include <algorithm>
#include <cstdlib>

#include "queries/distance_field.h"

namespace superray {

/// Occupied cells of one row along x; bit 0 is the first cell of the window.
__extension__ using RowBits = unsigned __int128;

inline int lowestBit(std::uint64_t v) {
    return __builtin_ctzll(v);
}
inline int highestBit(std::uint64_t v) {
    return 63 - __builtin_clzll(v);
}
inline int lowestBit(RowBits v) {
    const auto low = static_cast<std::uint64_t>(v);
    return low ? __builtin_ctzll(low)
               : 64 + __builtin_ctzll(static_cast<std::uint64_t>(v >> 64));
}
inline int highestBit(RowBits v) {
    const auto high = static_cast<std::uint64_t>(v >> 64);
    return high ? 127 - __builtin_clzll(high)
                : 63 - __builtin_clzll(static_cast<std::uint64_t>(v));
}

/// to = min(to, from + step) for n codes.
inline void takeNearer(const std::int32_t* from, std::int32_t step, std::int32_t* to, int n) {
    for (int i = 0; i < n; ++i) {
        const std::int32_t v = from[i] + step;
        to[i] = v < to[i] ? v : to[i];
    }
}

/// The exact squared distance is separable: nearest along x in each row, the
/// best of these along y, the best of those along z.
template <int Dim>
struct DistanceField<Dim>::Window {
    int reach, span;            ///< span: cells per axis that matter
    std::vector<RowBits> rows;  ///< [z][y], from -reach on
    bool any = false;

    explicit Window(double farthest)
        : reach(static_cast<int>(farthest)),
          span(kBlockEdge + 2 * reach),
          rows(static_cast<std::size_t>(Dim == 3 ? span * span : span)) {}

    RowBits& row(int z, int y) { return rows[static_cast<std::size_t>(z * span + y)]; }
    const RowBits& row(int z, int y) const {
        return rows[static_cast<std::size_t>(z * span + y)];
    }

    /// Index of the window's first block relative to the asking one.
    int blocksAround() const { return (reach + kBlockEdge - 1) / kBlockEdge; }

    /// \param d position of the block relative to the asking one
    void add(const Cell<Dim>& d, const BlockMask<Dim>& mask) {
        any = true;
        const int shift = (d[0] + blocksAround()) * kBlockEdge;
        for (int w = 0; w < BlockMask<Dim>::kWords; ++w) {
            const int z = Dim == 3 ? d[Dim - 1] * kBlockEdge + w + reach : 0;
            if (z < 0 || z >= (Dim == 3 ? span : 1)) continue;
            for (int r = 0; r < kBlockEdge; ++r) {
                const int y = d[1] * kBlockEdge + r + reach;
                if (y < 0 || y >= span) continue;
                const auto byte = static_cast<std::uint8_t>(
                    mask.words[static_cast<std::size_t>(w)] >> (kBlockEdge * r));
                row(z, y) |= RowBits{byte} << shift;
            }
        }
    }

    static std::int32_t stepCode(int axis, int distance) {
        return (distance * distance << kSquareShift) | (distance + kMaxReach)
                                                           << (kAxisBits * axis);
    }

    /// Nearest cell in the row for the block's 8 columns. \pre bits != 0
    template <class Bits>
    void alongX(Bits bits, std::int32_t* codes) const {
        constexpr int kHighest = 8 * sizeof(Bits) - 1;
        const int first = blocksAround() * kBlockEdge;
        for (int x = 0; x < kBlockEdge; ++x) {
            const Bits right = bits >> (first + x);
            const Bits left = bits << (kHighest - first - x);  // the column is the highest bit
            int best = kMaxReach + 1;
            if (right) best = lowestBit(right);
            if (left && kHighest - highestBit(left) <= best) best = highestBit(left) - kHighest;
            codes[x] = std::abs(best) <= reach ? stepCode(0, best) : kNothing;
        }
    }

    /// \return false if no row of the plane has an occupied cell
    bool alongXY(int z, std::int32_t* plane) const {
        bool found = false;
        std::fill_n(plane, kBlockEdge * kBlockEdge, kNothing);
        for (int y = 0; y < span; ++y) {
            if (!row(z, y)) continue;
            found = true;
            std::array<std::int32_t, kBlockEdge> nearest;
            // 64 bits hold 3 blocks on either side, and are faster.
            if (blocksAround() <= 3)
                alongX(static_cast<std::uint64_t>(row(z, y)), nearest.data());
            else
                alongX(row(z, y), nearest.data());
            for (int to = std::max(0, y - 2 * reach); to <= std::min(kBlockEdge - 1, y); ++to)
                takeNearer(nearest.data(), stepCode(1, y - reach - to), plane + kBlockEdge * to,
                           kBlockEdge);
        }
        return found;
    }

    void compute(std::int32_t* codes) const {
        if constexpr (Dim == 2) {
            alongXY(0, codes);
        } else {
            std::fill_n(codes, kBlockCells<Dim>, kNothing);
            std::array<std::int32_t, kBlockEdge * kBlockEdge> plane;
            for (int z = 0; z < span; ++z) {
                if (!alongXY(z, plane.data())) continue;
                for (int to = std::max(0, z - 2 * reach); to <= std::min(kBlockEdge - 1, z);
                     ++to)
                    takeNearer(plane.data(), stepCode(2, z - reach - to),
                               codes + kBlockEdge * kBlockEdge * to, kBlockEdge * kBlockEdge);
            }
        }
    }
};

}  // namespace superray
