// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file tree_growth.h
/// How many nodes writing to a pruned tree may make, found without writing.

#include <superray/storage/occupancy_map.h>

#include "tree/block_cubes.h"
#include "tree/block_order.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace superray {

/// Upper bounds of what a tree takes from its memory.
struct TreeGrowth {
    std::size_t nodes = 0;     ///< without the first of a tree
    std::size_t families = 0;  ///< nodes that get children
    std::size_t blocks = 0;    ///< blocks that were looked at
};

/// Follows TreeWriter::write() for block after block, and counts the nodes that it would
/// make. `Nodes` as in tree_update.h. What pruning gives back is not counted, so that the
/// count holds at every moment of the update.
template <typename Nodes>
class GrowthCount {
 public:
    static constexpr int Dim = Nodes::kDim;
    using Node = typename Nodes::Node;

    explicit GrowthCount(const Nodes& nodes) : nodes_(nodes) {}

    void add(const BlockView<Dim>& written) {
        ++growth_.blocks;
        const std::uint64_t morton = mortonOf<Dim>(written.key);
        Node node = nodes_.root();
        int depth = -1;  // of the last node on the way
        Node last = Nodes::kNull;
        while (node != Nodes::kNull) {
            last = node;
            if (++depth == kBlockDepth || !nodes_.hasChildren(node)) break;
            node = nodes_.child(node, childTowards<Dim>(morton, depth));
        }
        const TouchedCubes<Dim> touched(written.known);
        const bool isLeaf = last != Nodes::kNull && !nodes_.hasChildren(last);
        if (isLeaf &&
            !differs<kBlockBits>(nodes_.value(last), 0, written.known, written.values))
            return;
        if (depth < kBlockDepth) ways_.push_back({morton, depth, isLeaf});
        if (depth == kBlockDepth && !isLeaf)
            addInner<kBlockBits>(last, 0, touched, written.values);
        else
            addFresh<kBlockBits>(isLeaf, 0, touched, written.values);
    }

    TreeGrowth result() {
        addWays();
        return growth_;
    }

 private:
    static constexpr std::size_t kChildren = std::size_t{1} << Dim;

    /// Nodes to be made from `depth` down to a block.
    struct Way {
        std::uint64_t morton;
        int depth;    ///< of the node that is there already; -1: none is
        bool isLeaf;  ///< whether that is a leaf, which gets all children
    };

    static std::size_t bitCount(unsigned bits) {
        return static_cast<std::size_t>(__builtin_popcount(bits));
    }

    template <int level>
    static bool differs(float value, int offset, const BlockMask<Dim>& cells,
                        const float* values) {
        bool any = false;
        visitCube<Dim, level>(cells, offset, [&](int word, std::uint64_t bits) {
            for (; bits && !any; bits &= bits - 1)
                any = values[64 * word + __builtin_ctzll(bits)] != value;
        });
        return any;
    }

    /// A node with children.
    template <int level>
    void addInner(Node n, int offset, const TouchedCubes<Dim>& touched, const float* values) {
        for (unsigned bits = touched.template children<level - 1>(offset); bits;
             bits &= bits - 1) {
            const int i = __builtin_ctz(bits);
            const int at = offset + childOffset<Dim>(i, level - 1);
            const Node c = nodes_.child(n, i);
            if (c == Nodes::kNull) ++growth_.nodes;
            if constexpr (level > 1) {
                if (c == Nodes::kNull)
                    addFresh<level - 1>(false, at, touched, values);
                else if (nodes_.hasChildren(c))
                    addInner<level - 1>(c, at, touched, values);
                else if (differs<level - 1>(nodes_.value(c), at, touched.cells, values))
                    addFresh<level - 1>(true, at, touched, values);
            }
        }
    }

    /// A node that does not exist yet, or a leaf of another value.
    template <int level>
    void addFresh(bool isLeaf, int offset, const TouchedCubes<Dim>& touched,
                  const float* values) {
        if (hasWholeCube<Dim, level>(touched.cells, offset) &&
            isUniformCube<Dim, level>(values, offset))
            return;
        const unsigned which = touched.template children<level - 1>(offset);
        ++growth_.families;
        growth_.nodes += isLeaf ? kChildren : bitCount(which);
        if constexpr (level > 1)
            for (unsigned bits = which; bits; bits &= bits - 1)
                addFresh<level - 1>(isLeaf,
                                    offset + childOffset<Dim>(__builtin_ctz(bits), level - 1),
                                    touched, values);
    }

    /// Neighbouring blocks share the upper part of their ways.
    void addWays() {
        std::sort(ways_.begin(), ways_.end(),
                  [](const Way& a, const Way& b) { return a.morton < b.morton; });
        for (std::size_t i = 0; i < ways_.size(); ++i) {
            const Way& way = ways_[i];
            int shared = -1;  // depth of the last node of both ways
            if (i > 0) {
                const std::uint64_t differing = way.morton ^ ways_[i - 1].morton;
                shared = kBlockDepth;
                while (shared >= 0 && differing >> (Dim * (kBlockDepth - shared)) != 0)
                    --shared;
            }
            const auto made =
                static_cast<std::size_t>(kBlockDepth - std::max(way.depth, shared));
            growth_.families += made;
            growth_.nodes += way.isLeaf ? kChildren * made : made;
        }
        ways_.clear();
    }

    const Nodes& nodes_;
    TreeGrowth growth_;
    std::vector<Way> ways_;
};

}  // namespace superray
