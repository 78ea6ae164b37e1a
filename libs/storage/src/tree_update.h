#pragma once
/// \file tree_update.h
/// Writing to a pruned tree (octree, quadtree) block by block.
///
/// The trees differ in how they keep nodes only. `Nodes` is
///   kDim, Node, kNull        dimension; handle of a node; the handle of none
///   root(), createRoot()     kNull if the tree is empty
///   child(n, i)              kNull if absent; bit a of i is the half of axis a
///   createChild(n, i)
///   hasChildren(n)           a node without is a leaf, at any level
///   value(n), setValue(n, v)
///   expand(n)                gives a leaf all children, with its value
///   settle(n)                prunes n if all children are leaves of one value,
///                            else sets it to their maximum, as OctoMap does

#include <superray/core/block.h>

#include <cstdint>

namespace superray {

inline constexpr int kTreeDepth = 16;                        ///< root 0, cells 16
inline constexpr int kBlockDepth = kTreeDepth - kBlockBits;  ///< nodes the size of a block

/// Interleaved bits of a block key: the order of the blocks in the tree, and
/// the child numbers on the way from the root.
template <int Dim>
std::uint64_t mortonOf(const BlockKey<Dim>& key) {
    std::uint64_t m = 0;
    for (int bit = 0; bit < kBlockDepth; ++bit)
        for (int a = 0; a < Dim; ++a) {
            const auto k = static_cast<std::uint64_t>(key[a] + (1 << (kBlockDepth - 1)));
            m |= ((k >> bit) & 1) << (Dim * bit + a);
        }
    return m;
}

template <int Dim>
BlockKey<Dim> blockOfMorton(std::uint64_t morton) {
    BlockKey<Dim> key{};
    for (int a = 0; a < Dim; ++a) {
        for (int bit = 0; bit < kBlockDepth; ++bit)
            key[a] |= static_cast<std::int32_t>((morton >> (Dim * bit + a)) & 1) << bit;
        key[a] -= 1 << (kBlockDepth - 1);
    }
    return key;
}

/// Child number on the way to a block, from a node at `depth`.
template <int Dim>
int childTowards(std::uint64_t morton, int depth) {
    return static_cast<int>(morton >> (Dim * (kBlockDepth - 1 - depth))) & ((1 << Dim) - 1);
}

/// Cell index in the block of the first cell of child i, whose edge is 2^level.
template <int Dim>
constexpr int childOffset(int i, int level) {
    int offset = 0;
    for (int a = 0; a < Dim; ++a) offset |= ((i >> a) & 1) << (level + kBlockBits * a);
    return offset;
}

/// The bits of `mask` in the cube of edge 2^level whose first cell is `offset`,
/// word by word: visit(word number, bits).
template <int Dim, int level, typename Visit>
void visitCube(const BlockMask<Dim>& mask, int offset, Visit&& visit) {
    constexpr std::uint64_t row = (1u << (1 << level)) - 1;
    constexpr std::uint64_t rows = level == 0   ? row
                                   : level == 1 ? row * 0x101
                                   : level == 2 ? row * 0x1010101
                                                : row * 0x101010101010101;
    const int first = offset >> 6;
    for (int w = first; w < first + (Dim == 3 ? 1 << level : 1); ++w)
        visit(w, mask.words[static_cast<std::size_t>(w)] & (rows << (offset & 63)));
}

template <int Dim, int level>
bool anyInCube(const BlockMask<Dim>& mask, int offset) {
    std::uint64_t any = 0;
    visitCube<Dim, level>(mask, offset, [&](int, std::uint64_t bits) { any |= bits; });
    return any != 0;
}

/// One visit to a tree that changes cells of blocks. Blocks in the order of
/// mortonOf() share the way from the root; inner nodes are brought up to date
/// when the visit leaves them, at the latest on destruction.
template <typename Nodes>
class TreeWriter {
 public:
    static constexpr int Dim = Nodes::kDim;
    using Node = typename Nodes::Node;

    explicit TreeWriter(Nodes& nodes) : nodes_(nodes) {}
    ~TreeWriter() { leaveTo(-1); }
    TreeWriter(const TreeWriter&) = delete;
    TreeWriter& operator=(const TreeWriter&) = delete;

    /// Sets every cell of `touched` to update(cell index, value), where an
    /// unknown cell has value 0. Nodes are made only where something changes.
    /// `update` may be called more than once for a cell.
    /// \param saturated the bits of touched cells become (new value == clamp)
    /// \return true if a cell changed
    template <typename Update>
    bool updateBlock(std::uint64_t morton, const BlockMask<Dim>& touched, float clamp,
                     BlockMask<Dim>& saturated, const Update& update) {
        if (!touched.any()) return false;
        const Change<Update> change{touched, clamp, saturated, update};
        enterCommonAncestor(morton);
        bool created = false;
        if (depth_ < 0) {
            Node root = nodes_.root();
            if (root == Nodes::kNull) {
                root = nodes_.createRoot();
                created = true;
            }
            path_[depth_ = 0] = root;
        }
        while (depth_ < kBlockDepth) {
            const Node node = path_[depth_];
            if (!created && !nodes_.hasChildren(node)) {
                if (!changesLeaf<kBlockBits>(nodes_.value(node), 0, change)) return false;
                nodes_.expand(node);
            }
            const int i = childTowards<Dim>(morton, depth_);
            Node next = created ? Nodes::kNull : nodes_.child(node, i);
            created = next == Nodes::kNull;
            if (created) {
                markChanged();  // before the node exists, in case creation fails
                next = nodes_.createChild(node, i);
            }
            path_[++depth_] = next;
        }
        morton_ = morton;
        const bool changed = updateNode<kBlockBits>(path_[depth_], created, 0, change);
        if (changed) markChanged();
        return changed;
    }

 private:
    template <typename Update>
    struct Change {
        const BlockMask<Dim>& touched;
        float clamp;
        BlockMask<Dim>& saturated;
        const Update& update;
    };

    /// \param created the node is new: its value means nothing yet
    template <int level, typename Update>
    bool updateNode(Node node, bool created, int offset, const Change<Update>& c) {
        if constexpr (level == 0) {
            const float before = created ? 0.0f : nodes_.value(node);
            const float after = c.update(offset, before);
            if (after == c.clamp)
                c.saturated.set(offset);
            else
                c.saturated.reset(offset);
            if (!created && after == before) return false;
            nodes_.setValue(node, after);
            return true;
        } else {
            if (!created && !nodes_.hasChildren(node)) {
                if (!changesLeaf<level>(nodes_.value(node), offset, c)) return false;
                nodes_.expand(node);
            }
            bool changed = false;
            for (int i = 0; i < 1 << Dim; ++i) {
                const int childAt = offset + childOffset<Dim>(i, level - 1);
                if (!anyInCube<Dim, level - 1>(c.touched, childAt)) continue;
                Node child = nodes_.child(node, i);
                const bool isNew = child == Nodes::kNull;
                if (isNew) child = nodes_.createChild(node, i);
                if (updateNode<level - 1>(child, isNew, childAt, c)) changed = true;
            }
            if (changed) nodes_.settle(node);
            return changed;
        }
    }

    /// Whether a leaf larger than a cell has to be split.
    template <int level, typename Update>
    bool changesLeaf(float value, int offset, const Change<Update>& c) const {
        bool changes = false;
        visitCube<Dim, level>(c.touched, offset, [&](int word, std::uint64_t bits) {
            for (; bits && !changes; bits &= bits - 1) {
                const int i = 64 * word + __builtin_ctzll(bits);
                changes = c.update(i, value) != value;
            }
        });
        return changes;
    }

    /// Goes up to the last node on the path that holds the block, too.
    void enterCommonAncestor(std::uint64_t morton) {
        int common = depth_;
        while (common > 0 && (morton ^ morton_) >> (Dim * (kBlockDepth - common))) --common;
        leaveTo(common);
        morton_ = morton;
    }

    void leaveTo(int depth) {
        for (; depth_ > depth; --depth_)
            if (depth_ < changedAbove_) {
                nodes_.settle(path_[depth_]);
                changedAbove_ = depth_;
            }
    }

    /// Something changed below the deepest inner node of the path.
    void markChanged() { changedAbove_ = depth_ < kBlockDepth ? depth_ + 1 : kBlockDepth; }

    Nodes& nodes_;
    Node path_[kBlockDepth + 1]{};
    int depth_ = -1;            // of the deepest node on the path; -1: none
    std::uint64_t morton_ = 0;  // a block below that node
    int changedAbove_ = 0;      // path nodes of lower depth must be settled
};

}  // namespace superray
