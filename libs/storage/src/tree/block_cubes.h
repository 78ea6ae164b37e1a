// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file block_cubes.h
/// The cubes (squares) of 1, 2, 4, 8 cells per axis that a block consists of:
/// the nodes of a tree at and below the size of a block.

#include <superray/core/block.h>

#include <algorithm>
#include <cstdint>

namespace superray {

/// Cell index in the block of the first cell of child i, whose edge is 2^level.
template <int Dim>
constexpr int childOffset(int i, int level) {
    int offset = 0;
    for (int a = 0; a < Dim; ++a) offset |= ((i >> a) & 1) << (level + kBlockBits * a);
    return offset;
}

/// The cells of the cube of edge 2^level at cell 0, in one word of a mask.
template <int level>
inline constexpr std::uint64_t kCubeRows = [] {
    constexpr std::uint64_t row = (1u << (1 << level)) - 1;
    return level == 0   ? row
           : level == 1 ? row * 0x101
           : level == 2 ? row * 0x1010101
                        : row * 0x101010101010101;
}();

/// Words of a mask that the cube of edge 2^level has cells in.
template <int Dim, int level>
inline constexpr int kCubeWords = Dim == 3 ? 1 << level : 1;

/// The bits of `mask` in the cube of edge 2^level whose first cell is `offset`,
/// word by word: visit(word number, bits).
template <int Dim, int level, typename Visit>
void visitCube(const BlockMask<Dim>& mask, int offset, Visit&& visit) {
    const int first = offset >> 6;
    for (int w = first; w < first + kCubeWords<Dim, level>; ++w)
        visit(w, mask.words[static_cast<std::size_t>(w)] & (kCubeRows<level> << (offset & 63)));
}

/// Whether `mask` has all cells of a cube.
template <int Dim, int level>
bool hasWholeCube(const BlockMask<Dim>& mask, int offset) {
    std::uint64_t missing = 0;
    for (int w = 0; w < kCubeWords<Dim, level>; ++w)
        missing |= ~mask.words[static_cast<std::size_t>((offset >> 6) + w)] &
                   (kCubeRows<level> << (offset & 63));
    return missing == 0;
}

/// Calls visit(first cell of a row) for the rows of a cube.
template <int Dim, int level, typename Visit>
void visitRows(int offset, Visit&& visit) {
    for (int z = 0; z < (Dim == 3 ? 1 << level : 1); ++z)
        for (int y = 0; y < 1 << level; ++y) visit(offset + 8 * y + 64 * z);
}

/// One value for all cells of a cube.
template <int Dim, int level>
void fillCube(float* values, int offset, float value) {
    visitRows<Dim, level>(offset,
                          [&](int row) { std::fill_n(values + row, 1 << level, value); });
}

/// Whether all cells of a cube have one value.
template <int Dim, int level>
bool isUniformCube(const float* values, int offset) {
    const float first = values[offset];
    for (int z = 0; z < (Dim == 3 ? 1 << level : 1); ++z)
        for (int y = 0; y < 1 << level; ++y)
            for (int x = 0; x < 1 << level; ++x)
                if (values[offset + x + 8 * y + 64 * z] != first) return false;
    return true;
}

/// From bits at the first cells of cubes of edge 2^(level-1) to bits at the
/// first cells of the cubes of edge 2^level that hold them.
template <int Dim, int level>
BlockMask<Dim> parentCubes(const BlockMask<Dim>& cubes) {
    static_assert(level == 1 || level == 2);
    constexpr std::uint64_t firstCells = level == 1 ? 0x0055005500550055 : 0x0000001100000011;
    constexpr int half = 1 << (level - 1);
    BlockMask<Dim> parents;
    for (std::size_t w = 0; w < parents.words.size(); w += 2 * half) {
        std::uint64_t bits = cubes.words[w];
        if constexpr (Dim == 3) bits |= cubes.words[w + half];
        bits |= bits >> (8 * half);
        bits |= bits >> half;
        parents.words[w] = bits & firstCells;
    }
    return parents;
}

/// Bit i: the mask has child i, of edge 2^level, of the cube at `offset`.
template <int Dim, int level>
unsigned childrenIn(const BlockMask<Dim>& mask, int offset) {
    constexpr int half = 1 << level;
    const auto ofWord = [&](int w) {
        const std::uint64_t bits = mask.words[static_cast<std::size_t>(w)] >> (offset & 63);
        return static_cast<unsigned>((bits & 1) | (bits >> half & 1) << 1 |
                                     (bits >> (8 * half) & 1) << 2 |
                                     (bits >> (9 * half) & 1) << 3);
    };
    const int w = offset >> 6;
    if constexpr (Dim == 3)
        return ofWord(w) | ofWord(w + half) << 4;
    else
        return ofWord(w);
}

/// Touched cells, and bits at the first cells of touched cubes.
template <int Dim>
struct TouchedCubes {
    explicit TouchedCubes(const BlockMask<Dim>& touched)
        : cells(touched),
          cubes2(parentCubes<Dim, 1>(touched)),
          cubes4(parentCubes<Dim, 2>(cubes2)) {}

    /// Bit i: child i, of edge 2^level, of the cube at `offset` is touched.
    template <int level>
    unsigned children(int offset) const {
        return childrenIn<Dim, level>(level == 0   ? cells
                                      : level == 1 ? cubes2
                                                   : cubes4,
                                      offset);
    }

    const BlockMask<Dim>& cells;
    BlockMask<Dim> cubes2, cubes4;
};

/// Of a power of two of values; in an order that vectors can follow.
template <int n>
float highestOf(const float* values) {
    float highest[n];
    std::copy_n(values, n, highest);
    for (int half = n / 2; half > 0; half /= 2)
        for (int i = 0; i < half; ++i) highest[i] = std::max(highest[i], highest[i + half]);
    return highest[0];
}

}  // namespace superray
