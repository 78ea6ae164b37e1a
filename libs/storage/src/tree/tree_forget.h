// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file tree_forget.h
/// Removing what is outside a window from a pruned tree (see tree_update.h).

#include <superray/storage/occupancy_map.h>

#include "tree/block_order.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace superray {

/// Visits the nodes at the border of the window and beyond, not those within. Needs of
/// `Nodes::Editor`, besides what TreeWriter needs:
///   reserveSplit()      so that createChildren() of one leaf does not fail
///   removeChild(n, i)   a leaf; \return whether n has no children then
///   release(n)          a node without children and parent
template <typename Nodes>
class TreeForget {
 public:
    static constexpr int Dim = Nodes::kDim;
    using Node = typename Nodes::Node;
    using Editor = typename Nodes::Editor;
    using KeyVisitor = typename OccupancyMap<Dim>::KeyVisitor;

    TreeForget(Nodes& nodes, const BlockWindow<Dim>& window, KeyVisitor forgotten)
        : nodes_(nodes), editor_(nodes), window_(window), forgotten_(std::move(forgotten)) {}

    /// \throws std::bad_alloc; then each block is whole or gone
    void run() {
        const Node root = nodes_.root();
        if (root == Nodes::kNull) return;
        collect(root, 0, 0);
        if (gone_.empty()) return;
        if (forget(root, 0, 0)) {
            nodes_.setRoot(Nodes::kNull);
            editor_.release(root);
        }
        for (const std::uint64_t morton : gone_) forgotten_(blockOfMorton<Dim>(morton));
    }

 private:
    using Overlap = typename BlockWindow<Dim>::Overlap;
    static constexpr int kChildren = 1 << Dim;
    static constexpr unsigned kAll = (1u << kChildren) - 1;

    /// Blocks below a node.
    static std::uint64_t blocksBelow(int depth) {
        return std::uint64_t{1} << (Dim * (kBlockDepth - depth));
    }

    static std::uint64_t childMorton(std::uint64_t morton, int depth, int i) {
        return morton + static_cast<std::uint64_t>(i) * blocksBelow(depth + 1);
    }

    Overlap overlapOf(std::uint64_t morton, int depth) const {
        return window_.overlap(blockOfMorton<Dim>(morton),
                               blockOfMorton<Dim>(morton + blocksBelow(depth) - 1));
    }

    /// Finds what is to go; changes nothing.
    /// \param morton of the first block below the node
    void collect(Node n, int depth, std::uint64_t morton) {
        const Overlap overlap = overlapOf(morton, depth);
        if (overlap == Overlap::whole) return;
        if (depth < kBlockDepth && nodes_.hasChildren(n)) {
            for (int i = 0; i < kChildren; ++i)
                if (const Node c = nodes_.child(n, i); c != Nodes::kNull)
                    collect(c, depth + 1, childMorton(morton, depth, i));
            return;
        }
        for (std::uint64_t b = morton; b < morton + blocksBelow(depth); ++b) {
            const BlockKey<Dim> key = blockOfMorton<Dim>(b);
            if (overlap == Overlap::none || !window_.holds(key)) gone_.push_back(b);
        }
    }

    /// \return true if the node is to be removed: then it has no children
    bool forget(Node n, int depth, std::uint64_t morton) {
        switch (overlapOf(morton, depth)) {
            case Overlap::whole:
                return false;
            case Overlap::none:
                removeBelow(n);
                return true;
            case Overlap::part:
                break;
        }
        if (!nodes_.hasChildren(n)) {
            editor_.reserveSplit();
            editor_.createChildren(n, kAll, nodes_.value(n));
        }
        try {
            if (forgetChildren(n, depth, morton)) return true;
        } catch (...) {
            editor_.settle(n);
            throw;
        }
        editor_.settle(n);
        return false;
    }

    /// \return whether no children are left
    bool forgetChildren(Node n, int depth, std::uint64_t morton) {
        // What is all outside first: its memory may serve the others.
        for (const bool outside : {true, false})
            for (int i = 0; i < kChildren; ++i) {
                const Node c = nodes_.child(n, i);
                if (c == Nodes::kNull) continue;
                const std::uint64_t first = childMorton(morton, depth, i);
                if ((overlapOf(first, depth + 1) == Overlap::none) != outside) continue;
                if (forget(c, depth + 1, first) && editor_.removeChild(n, i)) return true;
            }
        return false;
    }

    void removeBelow(Node n) {
        if (!nodes_.hasChildren(n)) return;
        for (int i = 0; i < kChildren; ++i)
            if (const Node c = nodes_.child(n, i); c != Nodes::kNull) removeBelow(c);
        editor_.removeChildren(n);
    }

    Nodes& nodes_;
    Editor editor_;
    const BlockWindow<Dim>& window_;
    const KeyVisitor forgotten_;
    std::vector<std::uint64_t> gone_;  // blocks, by morton
};

}  // namespace superray
