// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Sets of cells of a block: spreading by faces, rows of 8 cells at a time.

#include <superray/core/block.h>

namespace superray {

inline constexpr std::uint64_t kLowColumn = 0x0101010101010101;  ///< x = 0
inline constexpr std::uint64_t kHighColumn = 0x8080808080808080;

/// All cells beside the given ones (and, maybe, some of these), inside the block.
template <int Dim>
BlockMask<Dim> dilated(const BlockMask<Dim>& cells) {
    BlockMask<Dim> out;
    constexpr int kWords = BlockMask<Dim>::kWords;
    for (int w = 0; w < kWords; ++w) {
        const std::uint64_t c = cells.words[w];
        std::uint64_t more = (c & ~kHighColumn) << 1 | (c & ~kLowColumn) >> 1 | c << 8 | c >> 8;
        if (w > 0) more |= cells.words[w - 1];
        if (w + 1 < kWords) more |= cells.words[w + 1];
        out.words[w] = more;
    }
    return out;
}

/// What of `within` is connected with `cells`, a subset, by faces inside a layer.
/// Steps of 1, 2 and 4 cells go through whole rows (columns) at once; a longer
/// step may be taken where all cells passed are in `within`.
inline std::uint64_t filledLayer(std::uint64_t cells, std::uint64_t within) {
    for (;;) {
        const std::uint64_t before = cells;
        std::uint64_t up = within & ~kLowColumn, down = within & ~kHighColumn;
        for (const int step : {1, 2, 4}) {
            cells |= (up & cells << step) | (down & cells >> step);
            up &= up << step;
            down &= down >> step;
        }
        up = down = within;
        for (const int step : {8, 16, 32}) {
            cells |= (up & cells << step) | (down & cells >> step);
            up &= up << step;
            down &= down >> step;
        }
        if (cells == before) return cells;
    }
}

/// Extends `cells`, a subset of `within`, to all that it connects by faces.
template <int Dim>
void fill(BlockMask<Dim>& cells, const BlockMask<Dim>& within) {
    constexpr int kWords = BlockMask<Dim>::kWords;
    if (within.all()) {
        cells = within;
        return;
    }
    for (;;) {
        const BlockMask<Dim> before = cells;
        for (int w = 0; w < kWords; ++w) {
            if (w > 0) cells.words[w] |= cells.words[w - 1] & within.words[w];
            cells.words[w] = filledLayer(cells.words[w], within.words[w]);
        }
        for (int w = kWords - 2; w >= 0; --w) {
            cells.words[w] |= cells.words[w + 1] & within.words[w];
            cells.words[w] = filledLayer(cells.words[w], within.words[w]);
        }
        if (cells == before) return;
    }
}

/// The cells of the neighbour block that are beside the given ones.
/// \param step -1 or 1: on which side of the axis the neighbour is
template <int Dim>
BlockMask<Dim> acrossFace(const BlockMask<Dim>& cells, int axis, int step) {
    BlockMask<Dim> out;
    constexpr int kWords = BlockMask<Dim>::kWords;
    if (axis == 2) {
        if (step > 0)
            out.words[0] = cells.words[kWords - 1];
        else
            out.words[kWords - 1] = cells.words[0];
        return out;
    }
    const int shift = axis == 0 ? 7 : 56;
    const std::uint64_t low = axis == 0 ? kLowColumn : 0xFF;
    for (int w = 0; w < kWords; ++w)
        out.words[w] =
            step > 0 ? cells.words[w] >> shift & low : (cells.words[w] & low) << shift;
    return out;
}

}  // namespace superray
