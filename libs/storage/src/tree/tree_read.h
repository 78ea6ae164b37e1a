// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file tree_read.h
/// Reading the cells of a block off the nodes of a tree (see tree_update.h).

#include <superray/core/saturation_source.h>

#include "tree/block_cubes.h"
#include "values/value_rules.h"

namespace superray {

/// Values and known cells of a node of edge 2^level, whose first cell is `offset`.
template <int level, typename Nodes>
void readNode(const Nodes& nodes, typename Nodes::Node node, int offset, float* values,
              BlockMask<Nodes::kDim>& known) {
    constexpr int Dim = Nodes::kDim;
    if (!nodes.hasChildren(node)) {
        fillCube<Dim, level>(values, offset, nodes.value(node));
        visitCube<Dim, level>(fullMask<Dim>(), offset, [&](int word, std::uint64_t bits) {
            known.words[static_cast<std::size_t>(word)] |= bits;
        });
    } else if constexpr (level > 0) {
        for (int i = 0; i < 1 << Dim; ++i)
            if (const auto child = nodes.child(node, i); child != Nodes::kNull)
                readNode<level - 1>(nodes, child, offset + childOffset<Dim>(i, level - 1),
                                    values, known);
    }
}

/// Adds the cells of a node that are at the lower clamp.
template <int level, typename Nodes>
void markSaturated(const Nodes& nodes, typename Nodes::Node node, int offset, float lowerClamp,
                   BlockMask<Nodes::kDim>& mask) {
    constexpr int Dim = Nodes::kDim;
    if (!nodes.hasChildren(node)) {
        if (nodes.value(node) != lowerClamp) return;
        visitCube<Dim, level>(fullMask<Dim>(), offset, [&](int word, std::uint64_t bits) {
            mask.words[static_cast<std::size_t>(word)] |= bits;
        });
    } else if constexpr (level > 0) {
        for (int i = 0; i < 1 << Dim; ++i)
            if (const auto child = nodes.child(node, i); child != Nodes::kNull)
                markSaturated<level - 1>(nodes, child, offset + childOffset<Dim>(i, level - 1),
                                         lowerClamp, mask);
    }
}

/// \param node of the size of a block, or a leaf above it
template <typename Nodes>
BlockSaturation<Nodes::kDim> saturationOfBlock(const Nodes& nodes, typename Nodes::Node node,
                                               float lowerClamp) {
    BlockSaturation<Nodes::kDim> result;
    markSaturated<kBlockBits>(nodes, node, 0, lowerClamp, result.saturatedFree);
    result.mayExceedUnknown = nodes.value(node) > 0;  // inner nodes have the highest
    return result;
}

}  // namespace superray
