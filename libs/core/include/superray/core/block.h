// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file block.h
/// Cells are handled in aligned cubic (square) blocks of 8 per axis: the unit
/// of the update batch, the culling region and the block grid.

#include <superray/core/cell.h>

#include <cstdint>
#include <functional>

namespace superray {

inline constexpr int kBlockBits = 3;
inline constexpr int kBlockEdge = 1 << kBlockBits;  ///< cells per axis

/// Number of cells in a block (64 in 2D, 512 in 3D).
template <int Dim>
inline constexpr int kBlockCells = 1 << (kBlockBits * Dim);

/// Index of a block: the cell index divided by kBlockEdge, rounded down.
template <int Dim>
using BlockKey = Cell<Dim>;

template <int Dim>
constexpr BlockKey<Dim> blockOf(const Cell<Dim>& c) {
    BlockKey<Dim> k{};
    for (int a = 0; a < Dim; ++a) k[a] = c[a] >> kBlockBits;
    return k;
}

/// Index of a cell inside its block: x + 8 y (+ 64 z).
template <int Dim>
constexpr int indexInBlock(const Cell<Dim>& c) {
    int i = 0;
    for (int a = Dim - 1; a >= 0; --a) i = (i << kBlockBits) | (c[a] & (kBlockEdge - 1));
    return i;
}

/// Inverse of (blockOf, indexInBlock).
template <int Dim>
constexpr Cell<Dim> cellInBlock(const BlockKey<Dim>& k, int index) {
    Cell<Dim> c{};
    for (int a = 0; a < Dim; ++a)
        c[a] = k[a] * kBlockEdge + ((index >> (kBlockBits * a)) & (kBlockEdge - 1));
    return c;
}

/// One bit per cell of a block; bit i of the whole is cell index i, so in 3D
/// word z holds the layer z and byte y of it the row y.
template <int Dim>
struct BlockMask {
    static constexpr int kWords = kBlockCells<Dim> / 64;
    std::array<std::uint64_t, kWords> words{};

    bool test(int i) const { return (words[i >> 6] >> (i & 63)) & 1u; }
    void set(int i) { words[i >> 6] |= std::uint64_t{1} << (i & 63); }
    void reset(int i) { words[i >> 6] &= ~(std::uint64_t{1} << (i & 63)); }
    bool any() const {
        std::uint64_t o = 0;
        for (auto w : words) o |= w;
        return o != 0;
    }
    bool all() const {
        std::uint64_t a = ~std::uint64_t{0};
        for (auto w : words) a &= w;
        return a == ~std::uint64_t{0};
    }
    int count() const {
        int n = 0;
        for (auto w : words) n += __builtin_popcountll(w);
        return n;
    }
    friend bool operator==(const BlockMask& a, const BlockMask& b) {
        return a.words == b.words;
    }
    friend bool operator!=(const BlockMask& a, const BlockMask& b) { return !(a == b); }
};

/// Hash of a cell or block index (both std::array<int32_t, Dim>).
struct IndexHash {
    template <std::size_t N>
    std::size_t operator()(const std::array<std::int32_t, N>& k) const {
        std::uint64_t h = 0x9E3779B97F4A7C15ull;
        for (auto v : k) {
            h ^= static_cast<std::uint32_t>(v);
            h *= 0xFF51AFD7ED558CCDull;
            h ^= h >> 32;
        }
        return static_cast<std::size_t>(h);
    }
};

}  // namespace superray
