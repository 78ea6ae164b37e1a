// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file tree_update.h
/// Writing to a pruned tree (octree, quadtree) block by block.
///
/// The trees differ in how they keep nodes only. `Nodes` is
///   kDim, Node, kNull        dimension; handle of a node; the handle of none
///   kParallel                whether several editors may work at once
///   root(), setRoot(n)       kNull if the tree is empty
///   child(n, i)              kNull if absent; bit a of i is the half of axis a
///   hasChildren(n)           a node without is a leaf, at any level
///   value(n)
///   readChildren(n, which, v)  values of the children, of which the bit set is
///                            returned; of absent ones 0 if in `which`, else kAbsent
///   prefetchFamily(n), prefetchChildren(n)  hints: what leads from a node to
///                            its children will be needed, and the children
/// and what a thread changes nodes with, `Nodes::Editor`:
///   reserve()                so that nothing fails while a block is written
///   setValue(n, v)
///   create()                 a node without parent
///   setChildren(n, v)        values of the children that exist
///   createChildren(n, which, v)  of bit set `which`, none of which exists;
///                            v: the value of all or an array of the values
///   removeChildren(n)        which all are leaves
///   settle(n)                prunes n if all children are leaves of one value,
///                            and sets it to their maximum, as OctoMap does
/// If kParallel, also attach(n, i, child).

#include "tree/block_cubes.h"
#include "tree/block_order.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace superray {

/// Less than every value, which are finite: stands for nodes that do not exist.
inline constexpr float kAbsent = -std::numeric_limits<float>::infinity();

/// One visit to a tree, or to what is below one node, that changes cells of
/// blocks. Blocks in the order of mortonOf() share the way from the root; inner
/// nodes are brought up to date when the visit leaves them, at the latest by
/// finish().
template <typename Nodes>
class TreeWriter {
 public:
    static constexpr int Dim = Nodes::kDim;
    using Node = typename Nodes::Node;
    using Editor = typename Nodes::Editor;
    using Values = std::array<float, kBlockCells<Dim>>;

    /// What a tree has where a block belongs.
    enum class Found {
        nothing,
        leaf,  ///< as large as the block or larger: all cells have one value
        inner
    };

    TreeWriter(Nodes& nodes, Editor& editor) : TreeWriter(nodes, editor, nodes.root(), 0) {}
    /// \param top node at `depth` on the way to all blocks that will be visited,
    ///        or kNull: it is made when needed, see finish()
    TreeWriter(Nodes& nodes, Editor& editor, Node top, int depth)
        : nodes_(nodes), editor_(editor), top_(top), topDepth_(depth), depth_(depth - 1) {}
    ~TreeWriter() { finish(); }
    TreeWriter(const TreeWriter&) = delete;
    TreeWriter& operator=(const TreeWriter&) = delete;

    /// Goes to where a block is; changes nothing in it.
    Found enter(std::uint64_t morton) { return enter(morton, kBlockDepth); }

    /// The node at which the way ended. \pre the last enter() found one
    Node node() const { return path_[depth_]; }

    /// The values of the cells of all families (the children of one node) with
    /// a touched cell; 0 where unknown and touched. \pre enter()
    void read(Found found, const BlockMask<Dim>& touched, Values& values) {
        if (found == Found::inner) {
            const Cube block{node(), 0};
            readCubes<kBlockBits>(&block, 1, Touched(touched), values.data());
        } else if (found == Found::leaf) {
            values.fill(nodes_.value(node()));
        } else {
            for (std::size_t w = 0; w < touched.words.size(); ++w)
                if (touched.words[w] != 0) std::fill_n(values.data() + 64 * w, 64, 0.0f);
        }
    }

    /// Sets the touched cells of the block. \pre enter(), read(), editor.reserve()
    /// \param values of touched cells: the new ones; of other cells of their
    ///        families: as read
    void write(Found found, const BlockMask<Dim>& touched, const Values& values) {
        if (found == Found::leaf &&
            !differs<kBlockBits>(nodes_.value(node()), 0, touched, values.data()))
            return;
        const bool created = makeWay();
        writeNode<kBlockBits>(node(), created ? Found::nothing : foundAt(node()), 0,
                              Touched(touched), values.data());
        markChanged();
    }

    /// Goes to the node at `depth` over the block; changes nothing.
    /// \param leaf set if there is none because a leaf is above it
    /// \return kNull if there is none
    Node find(std::uint64_t morton, int depth, bool& leaf) {
        leaf = enter(morton, depth) == Found::leaf && depth_ < depth;
        return depth_ == depth ? node() : Nodes::kNull;
    }

    /// Puts a node at `depth` on the way to the block if it is not there, and
    /// settles what is above it. \pre editor.reserve()
    void attach(std::uint64_t morton, int depth, Node node) {
        enter(morton, depth - 1);
        makeWay(depth - 1);
        const int i = childTowards<Dim>(morton, depth - 1);
        if (nodes_.child(path_[depth_], i) == Nodes::kNull)
            editor_.attach(path_[depth_], i, node);
        ++depth_;
        path_[depth_] = node;
        markChanged();
    }

    /// Brings inner nodes up to date. \return the top node; kNull: still none
    Node finish() {
        leaveTo(topDepth_ - 1);
        return top_;
    }

 private:
    static constexpr unsigned kAll = (1u << (1 << Dim)) - 1;

    using Touched = TouchedCubes<Dim>;

    Found foundAt(Node n) const { return nodes_.hasChildren(n) ? Found::inner : Found::leaf; }

    Found enter(std::uint64_t morton, int depth) {
        leaveForCommonAncestor(morton, depth);
        if (depth_ < topDepth_) {
            if (top_ == Nodes::kNull) return Found::nothing;
            path_[depth_ = topDepth_] = top_;
        }
        while (depth_ < depth) {
            if (!nodes_.hasChildren(node())) return Found::leaf;
            const Node next = nodes_.child(node(), childTowards<Dim>(morton, depth_));
            if (next == Nodes::kNull) return Found::nothing;
            path_[++depth_] = next;
        }
        return foundAt(node());
    }

    /// Makes nodes down to the block. \return whether its node is new
    bool makeWay(int depth = kBlockDepth) {
        bool created = false;
        if (depth_ < topDepth_) {
            top_ = editor_.create();
            if (topDepth_ == 0) nodes_.setRoot(top_);
            path_[depth_ = topDepth_] = top_;
            created = true;
        }
        while (depth_ < depth) {
            const Node n = node();
            const int i = childTowards<Dim>(morton_, depth_);
            if (!created && !nodes_.hasChildren(n)) {
                editor_.createChildren(n, kAll, nodes_.value(n));
            } else if (created || nodes_.child(n, i) == Nodes::kNull) {
                editor_.createChildren(n, 1u << i, 0.0f);
                created = true;
            }
            path_[++depth_] = nodes_.child(n, i);
        }
        return created;
    }

    /// A node and the first cell of its cube.
    struct Cube {
        Node node;
        int offset;
    };

    /// Level by level, and each in steps whose memory accesses do not wait for
    /// one another: nodes are seldom in the cache.
    template <int level>
    void readCubes(const Cube* cubes, int count, const Touched& touched, float* values) {
        for (int k = 0; k < count; ++k) nodes_.prefetchFamily(cubes[k].node);
        if constexpr (level == 1)
            for (int k = 0; k < count; ++k) nodes_.prefetchChildren(cubes[k].node);
        std::array<Cube, std::size_t{1} << (Dim * (kBlockBits - level + 1))> children;
        int childCount = 0;
        for (int k = 0; k < count; ++k) {
            const auto [n, offset] = cubes[k];
            if (!nodes_.hasChildren(n)) {
                fillCube<Dim, level>(values, offset, nodes_.value(n));
            } else if constexpr (level == 1) {
                float family[1 << Dim];
                had_[static_cast<std::size_t>(offset)] =
                    nodes_.readChildren(n, touched.template children<0>(offset), family);
                for (int i = 0; i < 1 << Dim; ++i)
                    values[offset + childOffset<Dim>(i, 0)] = family[i];
            } else {
                for (unsigned bits = touched.template children<level - 1>(offset); bits;
                     bits &= bits - 1) {
                    const int i = __builtin_ctz(bits);
                    const int at = offset + childOffset<Dim>(i, level - 1);
                    if (const Node c = nodes_.child(n, i); c != Nodes::kNull)
                        children[static_cast<std::size_t>(childCount++)] = {c, at};
                    else
                        fillCube<Dim, level - 1>(values, at, 0.0f);
                }
            }
        }
        if constexpr (level > 1)
            readCubes<level - 1>(children.data(), childCount, touched, values);
    }

    template <int level>
    void writeNode(Node n, Found found, int offset, const Touched& touched,
                   const float* values) {
        if constexpr (level == 1) {
            writeFamily(n, found, offset, touched.template children<0>(offset), values);
        } else {
            if (found != Found::inner) {
                if (found == Found::leaf &&
                    !differs<level>(nodes_.value(n), offset, touched.cells, values))
                    return;
                if (hasWholeCube<Dim, level>(touched.cells, offset) &&
                    isUniformCube<Dim, level>(values, offset)) {
                    editor_.setValue(n, values[offset]);
                    return;
                }
            }
            const unsigned which = touched.template children<level - 1>(offset);
            unsigned fresh = 0;
            if (found == Found::leaf) {
                editor_.createChildren(n, kAll, nodes_.value(n));
            } else {
                fresh = which;
                if (found == Found::inner)
                    for (unsigned bits = which; bits; bits &= bits - 1)
                        if (nodes_.child(n, __builtin_ctz(bits)) != Nodes::kNull)
                            fresh ^= bits & -bits;
                if (fresh != 0) editor_.createChildren(n, fresh, 0.0f);
            }
            for (unsigned bits = which; bits; bits &= bits - 1) {
                const int i = __builtin_ctz(bits);
                const Node c = nodes_.child(n, i);
                writeNode<level - 1>(c, fresh >> i & 1 ? Found::nothing : foundAt(c),
                                     offset + childOffset<Dim>(i, level - 1), touched, values);
            }
            editor_.settle(n);
        }
    }

    /// writeNode() for a node whose children are cells.
    void writeFamily(Node n, Found found, int offset, unsigned touched, const float* values) {
        constexpr int kFamily = 1 << Dim;
        float family[kFamily];
        for (int i = 0; i < kFamily; ++i) family[i] = values[offset + childOffset<Dim>(i, 0)];
        const unsigned had = found == Found::inner ? had_[static_cast<std::size_t>(offset)]
                                                   : (found == Found::leaf ? kAll : 0u);
        const unsigned has = had | touched;
        if (has == kAll) {
            bool same = true;
            for (int i = 1; i < kFamily; ++i) same &= family[i] == family[0];
            if (same) {
                if (found == Found::inner) editor_.removeChildren(n);
                editor_.setValue(n, family[0]);
                return;
            }
        }
        if (found == Found::inner) editor_.setChildren(n, family);
        if (found == Found::nothing)
            for (int i = 0; i < kFamily; ++i)
                if (!(has >> i & 1)) family[i] = kAbsent;
        const unsigned fresh = found == Found::leaf ? kAll : touched & ~had;
        if (fresh != 0) editor_.createChildren(n, fresh, family);
        editor_.setValue(n, highestOf<kFamily>(family));
    }

    /// Whether a touched cell of a cube has another value.
    template <int level>
    bool differs(float value, int offset, const BlockMask<Dim>& touched,
                 const float* values) const {
        bool any = false;
        visitCube<Dim, level>(touched, offset, [&](int word, std::uint64_t bits) {
            for (; bits && !any; bits &= bits - 1)
                any = values[64 * word + __builtin_ctzll(bits)] != value;
        });
        return any;
    }

    /// Goes up to the last node on the path that holds the block, too, and is
    /// not below `depth`.
    void leaveForCommonAncestor(std::uint64_t morton, int depth) {
        int common = std::min(depth_, depth);
        while (common > topDepth_ && (morton ^ morton_) >> (Dim * (kBlockDepth - common)))
            --common;
        leaveTo(common);
        morton_ = morton;
    }

    void leaveTo(int depth) {
        for (; depth_ > depth; --depth_)
            if (depth_ < changedAbove_) {
                editor_.settle(path_[depth_]);
                changedAbove_ = depth_;
            }
    }

    /// What is above the deepest node of the path must be settled.
    void markChanged() { changedAbove_ = depth_; }

    Nodes& nodes_;
    Editor& editor_;
    Node top_;
    const int topDepth_;
    Node path_[kBlockDepth + 1]{};
    int depth_;                 // of the deepest node on the path; topDepth_ - 1: none
    std::uint64_t morton_ = 0;  // a block below that node
    int changedAbove_ = 0;      // path nodes of lower depth must be settled
    std::array<std::uint8_t, kBlockCells<Dim>> had_;  // by first cell: children that were read
};

}  // namespace superray
