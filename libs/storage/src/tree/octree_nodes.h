// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file octree_nodes.h
/// The nodes of Octree: an octomap::OcTree with an arena.

#include <superray/core/detail/always_inline.h>
#include <superray/core/sensor_model.h>

#include "tree/node_arena.h"
#include "tree/tree_growth.h"
#include "tree/tree_update.h"

#include <octomap/OcTree.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <type_traits>
#include <utility>

namespace superray {

/// A node whose memory is its tree's.
class ArenaNode final : public octomap::OcTreeNode {
 public:
    ArenaNode() = default;
    explicit ArenaNode(float v) { setLogOdds(v); }

    octomap::AbstractOcTreeNode** children() const { return OcTreeNode::children; }
    void setChildren(octomap::AbstractOcTreeNode** c) { OcTreeNode::children = c; }
};

/// OctoMap's tree, with what TreeWriter needs and OctoMap keeps to itself, and
/// with all nodes in an arena: a node is 16 bytes instead of malloc's 32, and
/// nodes that are made together lie together. OctoMap's code must never free
/// one, so all functions that do are replaced here or not called.
class OcTreeNodes final : public octomap::OcTree {
 public:
    static constexpr int kDim = 3;
    static constexpr bool kParallel = true;
    using Node = octomap::OcTreeNode*;
    static constexpr Node kNull = nullptr;

    explicit OcTreeNodes(double cellEdge) : octomap::OcTree(cellEdge) {}
    OcTreeNodes(const OcTreeNodes& o) : octomap::OcTree(o.resolution) {
        setProbHit(o.getProbHit());
        setProbMiss(o.getProbMiss());
        setClampingThresMin(o.getClampingThresMin());
        setClampingThresMax(o.getClampingThresMax());
        setOccupancyThres(o.getOccupancyThres());
        if (o.root() == kNull) return;
        try {
            Editor editor(*this);
            editor.reserve();
            setRoot(editor.create());
            editor.copyBelow(o.root(), root());
        } catch (...) {
            clearNodes();  // OctoMap's destructor, which comes next, would free them
            throw;
        }
    }
    OcTreeNodes& operator=(const OcTreeNodes&) = delete;
    ~OcTreeNodes() override { clearNodes(); }

    // Handles are to non-const nodes; only Editor changes them.
    Node root() const { return octomap::OcTree::root; }
    void setRoot(Node n) { octomap::OcTree::root = n; }
    static Node child(Node n, int i) {
        octomap::AbstractOcTreeNode** const c = arenaNode(n)->children();
        return c == nullptr ? kNull : static_cast<Node>(c[i]);
    }
    /// Inner nodes have a child: families without one are never left behind.
    static bool hasChildren(Node n) { return arenaNode(n)->children() != nullptr; }
    static float value(Node n) { return n->getLogOdds(); }
    std::uint8_t readChildren(Node n, unsigned which, float* values) const {
        // Without branches: which cells are known is hard to predict.
        const octomap::AbstractOcTreeNode* const* const c = arenaNode(n)->children();
        unsigned had = 0;
        for (int i = 0; i < 8; ++i) {
            const octomap::AbstractOcTreeNode* const none = absent_ + (which >> i & 1);
            values[i] =
                static_cast<const ArenaNode*>(c[i] != nullptr ? c[i] : none)->getLogOdds();
            had |= static_cast<unsigned>(c[i] != nullptr) << i;
        }
        return static_cast<std::uint8_t>(had);
    }
    static void prefetchFamily(Node n) { __builtin_prefetch(arenaNode(n)->children()); }
    static void prefetchChildren(Node n) {
        octomap::AbstractOcTreeNode** const c = arenaNode(n)->children();
        if (c == nullptr) return;
        for (int i = 0; i < 8; ++i) __builtin_prefetch(c[i]);
    }

    /// One thread's means to change nodes.
    class Editor {
     public:
        explicit Editor(OcTreeNodes& nodes) : nodes_(nodes), share_(nodes.arena_) {}
        /// \pre one editor at a time
        ~Editor() {
            nodes_.tree_size += static_cast<std::size_t>(made_);
            nodes_.size_changed = true;  // OctoMap's cached bounds
        }
        Editor(const Editor&) = delete;
        Editor& operator=(const Editor&) = delete;

        /// Makes sure that nothing fails until a block and the way to it are
        /// made.
        void reserve() { share_.reserve(kBlockBytes); }
        /// The same for so many ways without blocks. \pre no leaf is in their way
        void reserveWays(std::size_t ways) { share_.reserve(ways * kWayBytes); }

        static void setValue(Node n, float v) { n->setLogOdds(v); }
        /// A node without parent.
        Node create() {
            ++made_;
            return newNode(share_.node(), 0.0f);
        }
        /// The children of bit set `which`, of which there is none.
        /// \param values of 8 children
        void createChildren(Node n, unsigned which, const float* values) {
            octomap::AbstractOcTreeNode** const c = childrenOf(n);
            const int count = __builtin_popcount(which);
            std::byte* row = share_.nodesInARow(static_cast<std::size_t>(count));
            for (unsigned bits = which; bits; bits &= bits - 1) {
                const int i = __builtin_ctz(bits);
                if (row != nullptr) {
                    c[i] = newNode(row, values[i]);
                    row += NodeArena::kNodeBytes;
                } else {
                    c[i] = newNode(share_.node(), values[i]);
                }
            }
            made_ += count;
        }
        void setChildren(Node n, const float* values) {
            octomap::AbstractOcTreeNode** const c = arenaNode(n)->children();
            for (int i = 0; i < 8; ++i)  // without branches, see readChildren()
                static_cast<ArenaNode*>(c[i] != nullptr ? c[i] : &unused_)
                    ->setLogOdds(values[i]);
        }
        void createChildren(Node n, unsigned which, float value) {
            const float values[8] = {value, value, value, value, value, value, value, value};
            createChildren(n, which, values);
        }
        /// Makes a node without parent a child.
        void attach(Node n, int i, Node child) { childrenOf(n)[i] = child; }
        /// \pre the children are leaves
        void removeChildren(Node n) {
            octomap::AbstractOcTreeNode** const c = arenaNode(n)->children();
            // Backwards, so that they are used again in the order of memory.
            for (int i = 8; i-- > 0;)
                if (c[i] != nullptr) {
                    share_.releaseNode(static_cast<Node>(c[i]));
                    --made_;
                }
            share_.releaseFamily(c);
            arenaNode(n)->setChildren(nullptr);
        }
        /// Removes one child, a leaf. \return whether that was the last: then n is a leaf
        bool removeChild(Node n, int i) {
            octomap::AbstractOcTreeNode** const c = arenaNode(n)->children();
            release(static_cast<Node>(std::exchange(c[i], nullptr)));
            if (std::any_of(c, c + 8, [](const auto* child) { return child != nullptr; }))
                return false;
            share_.releaseFamily(c);
            arenaNode(n)->setChildren(nullptr);
            return true;
        }
        /// Takes a node without children and parent back.
        void release(Node n) {
            share_.releaseNode(n);
            --made_;
        }
        // What TreeForget asks for.
        void reserveSplit() {
            share_.reserve(NodeArena::kFamilyBytes + 8 * NodeArena::kNodeBytes);
        }
        SUPERRAY_INLINE void settle(Node n) {
            // As pruneNode() and updateOccupancyChildren(), in one visit.
            const octomap::AbstractOcTreeNode* const* const c = arenaNode(n)->children();
            bool same = true;
            float values[8];
            for (int i = 0; i < 8; ++i) {
                const auto* const child =
                    static_cast<const ArenaNode*>(c[i] != nullptr ? c[i] : nodes_.absent_);
                values[i] = child->getLogOdds();
                same &= (child->children() == nullptr) & (values[i] == values[0]);
            }
            setValue(n, highestOf<8>(values));
            if (same) removeChildren(n);  // some exist, so all do
        }
        void copyBelow(Node from, Node to) {
            setValue(to, value(from));
            unsigned which = 0;
            float values[8] = {};
            for (int i = 0; i < 8; ++i)
                if (const Node c = child(from, i); c != kNull) {
                    which |= 1u << i;
                    values[i] = value(c);
                }
            if (which == 0) return;
            reserve();
            createChildren(to, which, values);
            for (; which; which &= which - 1) {
                const int i = __builtin_ctz(which);
                copyBelow(child(from, i), child(to, i));
            }
        }

        /// Nodes and families of a block and the way to it, at most.
        static constexpr std::size_t kBlockFamilies = kBlockDepth + kFamiliesOfBlock<3>,
                                     kBlockNodes = 1 + 8 * kBlockFamilies;
        static constexpr std::size_t kBlockBytes =
            kBlockNodes * NodeArena::kNodeBytes + kBlockFamilies * NodeArena::kFamilyBytes;

     private:
        static constexpr std::size_t kWayBytes =
            NodeArena::kNodeBytes +
            kBlockDepth * (NodeArena::kFamilyBytes + NodeArena::kNodeBytes);

        octomap::AbstractOcTreeNode** childrenOf(Node n) {
            octomap::AbstractOcTreeNode** c = arenaNode(n)->children();
            if (c == nullptr) {
                c = (new (share_.family()) Family{})->children;
                arenaNode(n)->setChildren(c);
            }
            return c;
        }
        Node newNode(void* memory, float value) const {
            // A copy of a node without children. OctoMap's constructors do no
            // more, but a call for every node shows.
            std::memcpy(memory, static_cast<const void*>(&nodes_.absent_[0]),
                        sizeof(ArenaNode));
            const Node n = static_cast<ArenaNode*>(memory);
            n->setLogOdds(value);
            return n;
        }

        OcTreeNodes& nodes_;
        NodeArena::Share share_;
        ArenaNode unused_;
        std::ptrdiff_t made_ = 0;  // less those released
    };

    void swapWith(OcTreeNodes& o) {
        std::swap(octomap::OcTree::root, o.octomap::OcTree::root);
        std::swap(tree_size, o.tree_size);
        arena_.swap(o.arena_);
        size_changed = o.size_changed = true;  // OctoMap's cached bounds
    }

    std::size_t heldBytes() const { return sizeof *this + arena_.chunkBytes(); }
    std::size_t heldBytesWith(const TreeGrowth& growth, unsigned threads) const {
        if (growth.blocks == 0) return heldBytes();
        return sizeof *this + arena_.chunkBytesAtMost(demandOf(growth, threads));
    }
    /// The most that writing to so many blocks can make.
    static TreeGrowth growthAtMost(std::size_t blocks) {
        return {blocks * Editor::kBlockNodes, blocks * Editor::kBlockFamilies, blocks};
    }
    /// Makes sure that a growth by so many threads cannot fail. \throws std::bad_alloc
    void keepRoom(const TreeGrowth& growth, unsigned threads) {
        if (growth.blocks > 0) arena_.keepRoom(demandOf(growth, threads));
    }

    void reserve(std::size_t bytes) { arena_.reserve(bytes); }
    std::size_t reservedBytes() const { return arena_.reservedBytes(); }

    void clearNodes() {
        octomap::OcTree::root = nullptr;
        tree_size = 0;
        size_changed = true;
        arena_.clear();
    }

    void use(const SensorProbabilities& p) {
        setProbHit(p.probHit);
        setProbMiss(p.probMiss);
        setClampingThresMin(p.clampMin);
        setClampingThresMax(p.clampMax);
        setOccupancyThres(p.occupancyThreshold);
    }

 private:
    struct Family {
        octomap::AbstractOcTreeNode* children[8];
    };
    static_assert(!std::is_polymorphic_v<ArenaNode>);
    static_assert(sizeof(ArenaNode) <= NodeArena::kNodeBytes &&
                  sizeof(Family) <= NodeArena::kFamilyBytes);

    static ArenaNode* arenaNode(Node n) { return static_cast<ArenaNode*>(n); }
    static NodeArena::Demand demandOf(const TreeGrowth& g, unsigned threads) {
        return {g.nodes, g.families, Editor::kBlockBytes, threads};
    }

    NodeArena arena_;
    const ArenaNode absent_[2]{ArenaNode(kAbsent), ArenaNode(0)};
};

}  // namespace superray
