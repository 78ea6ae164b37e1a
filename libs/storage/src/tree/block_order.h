// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file block_order.h
/// The order of blocks in a tree.

#include <superray/core/block.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace superray {

inline constexpr int kTreeDepth = 16;                        ///< root 0, cells 16
inline constexpr int kBlockDepth = kTreeDepth - kBlockBits;  ///< nodes the size of a block

/// Nodes with children in a block that is not uniform anywhere: 1 + 8 + 64 in 3D.
template <int Dim>
inline constexpr std::size_t kFamiliesOfBlock = (std::size_t{kBlockCells<Dim>} - 1) /
                                                ((std::size_t{1} << Dim) - 1);

namespace detail {
// Bits of a block index, moved apart step by step. A step doubles the number
// of groups of neighbouring bits; the masks keep the bits that belong there.
template <int Dim>
struct Spread;
template <>
struct Spread<2> {
    static constexpr int kSteps = 4;
    static constexpr int kShift[kSteps] = {8, 4, 2, 1};
    static constexpr std::uint64_t kMask[kSteps + 1] = {0x0000FFFF, 0x00FF00FF, 0x0F0F0F0F,
                                                        0x33333333, 0x55555555};
};
template <>
struct Spread<3> {
    static constexpr int kSteps = 4;
    static constexpr int kShift[kSteps] = {16, 8, 4, 2};
    static constexpr std::uint64_t kMask[kSteps + 1] = {
        0x00000000FFFF, 0x0000FF0000FF, 0x00F00F00F00F, 0x0C30C30C30C3, 0x249249249249};
};
}  // namespace detail

/// Interleaved bits of a block key: the order of the blocks in the tree, and
/// the child numbers on the way from the root.
template <int Dim>
std::uint64_t mortonOf(const BlockKey<Dim>& key) {
    using Steps = detail::Spread<Dim>;
    std::uint64_t m = 0;
    for (int a = 0; a < Dim; ++a) {
        auto k = static_cast<std::uint64_t>(key[a] + (1 << (kBlockDepth - 1)));
        for (int s = 0; s < Steps::kSteps; ++s)
            k = (k | k << Steps::kShift[s]) & Steps::kMask[s + 1];
        m |= k << a;
    }
    return m;
}

template <int Dim>
BlockKey<Dim> blockOfMorton(std::uint64_t morton) {
    using Steps = detail::Spread<Dim>;
    BlockKey<Dim> key{};
    for (int a = 0; a < Dim; ++a) {
        std::uint64_t k = (morton >> a) & Steps::kMask[Steps::kSteps];
        for (int s = Steps::kSteps; s-- > 0;) k = (k | k >> Steps::kShift[s]) & Steps::kMask[s];
        key[a] = static_cast<std::int32_t>(k) - (1 << (kBlockDepth - 1));
    }
    return key;
}

/// Child number on the way to a block, from a node at `depth`.
template <int Dim>
int childTowards(std::uint64_t morton, int depth) {
    return static_cast<int>(morton >> (Dim * (kBlockDepth - 1 - depth))) & ((1 << Dim) - 1);
}

/// A block of a batch.
struct OrderedBlock {
    std::uint64_t morton;
    std::uint32_t number;  ///< in the batch
    std::uint32_t entry;   ///< in the SaturationCache
};

/// Sorts by morton, in time proportional to the number of blocks.
/// \param scratch of any contents
inline void sortBlocks(std::vector<OrderedBlock>& blocks, std::vector<OrderedBlock>& scratch) {
    constexpr int kBits = 11;
    constexpr std::size_t kBuckets = std::size_t{1} << kBits;
    std::uint64_t differing = 0;
    for (const OrderedBlock& b : blocks) differing |= b.morton ^ blocks.front().morton;
    scratch.resize(blocks.size());
    for (int shift = 0; shift < 64 && differing >> shift != 0; shift += kBits) {
        const auto bucketOf = [&](const OrderedBlock& b) {
            return static_cast<std::size_t>(b.morton >> shift) & (kBuckets - 1);
        };
        if (((differing >> shift) & (kBuckets - 1)) == 0) continue;
        std::size_t first[kBuckets + 1] = {};
        for (const OrderedBlock& b : blocks) ++first[bucketOf(b) + 1];
        for (std::size_t i = 0; i < kBuckets; ++i) first[i + 1] += first[i];
        for (const OrderedBlock& b : blocks) scratch[first[bucketOf(b)]++] = b;
        blocks.swap(scratch);
    }
}

}  // namespace superray
