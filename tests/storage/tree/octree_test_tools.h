// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file octree_test_tools.h
/// Our octree against OctoMap's, node by node.

#include "storage/storage_test_tools.h"

#include <octomap/OcTree.h>

#include <memory>

namespace superray::test {

inline octomap::OcTreeKey keyOf(const Cell<3>& c) {
    const auto k = [](std::int32_t v) {
        return static_cast<octomap::key_type>(v + kCellLimit);
    };
    return {k(c[0]), k(c[1]), k(c[2])};
}

/// OctoMap's own tree with these cells, set one by one (it prunes as it goes).
inline std::unique_ptr<octomap::OcTree> octomapTree(const Cells<3>& cells, double resolution) {
    auto tree = std::make_unique<octomap::OcTree>(resolution);
    for (const auto& [cell, value] : cells) tree->setNodeValue(keyOf(cell), value);
    tree->updateInnerOccupancy();
    tree->prune();
    return tree;
}

/// Same nodes at the same depths with the same bits, leaves and inner nodes.
inline ::testing::AssertionResult sameNodes(const octomap::OcTree& ours,
                                            const octomap::OcTree& theirs) {
    if (ours.size() != theirs.size())
        return ::testing::AssertionFailure()
               << "size() " << ours.size() << ", OctoMap " << theirs.size();
    if (ours.calcNumNodes() != ours.size())
        return ::testing::AssertionFailure() << "size() is not the number of nodes";
    auto a = ours.begin_tree(), b = theirs.begin_tree();
    for (; a != ours.end_tree() && b != theirs.end_tree(); ++a, ++b) {
        if (a.getDepth() != b.getDepth() || a.getKey() != b.getKey() ||
            a.isLeaf() != b.isLeaf())
            return ::testing::AssertionFailure() << "different structure";
        if (bitsOf(a->getLogOdds()) != bitsOf(b->getLogOdds()))
            return ::testing::AssertionFailure()
                   << "value " << a->getLogOdds() << ", OctoMap " << b->getLogOdds()
                   << " at depth " << a.getDepth();
    }
    if ((a != ours.end_tree()) || (b != theirs.end_tree()))
        return ::testing::AssertionFailure() << "different number of nodes visited";
    return ::testing::AssertionSuccess();
}

}  // namespace superray::test
