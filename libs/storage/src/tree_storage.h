#pragma once
/// \file tree_storage.h
/// All that Octree and Quadtree do, over the nodes of either.

#include "fold_layers.h"
#include "saturation_cache.h"
#include "saturation_clamp.h"
#include "tree_update.h"
#include "value_rules.h"

#include <superray/storage/occupancy_map.h>

#include <algorithm>
#include <utility>

namespace superray {

template <typename Nodes>
class TreeStorage {
 public:
    static constexpr int Dim = Nodes::kDim;
    using Node = typename Nodes::Node;

    template <typename... Args>
    explicit TreeStorage(const Args&... args) : nodes(args...) {}

    Nodes nodes;
    SaturationCache<Dim> cache;

    void apply(const UpdateBatch<Dim>& batch, const SensorModel& model, UpdatePolicy policy) {
        for (std::size_t b = 0; b < batch.blockCount(); ++b)
            requireAddressableBlock<Dim>(batch.key(b));

        cache.use(model.min(), 2 * batch.blockCount());

        // In the order of the tree, so that neighbours share the way down.
        std::vector<std::pair<std::uint64_t, std::size_t>> blocks(batch.blockCount());
        for (std::size_t b = 0; b < blocks.size(); ++b)
            blocks[b] = {mortonOf<Dim>(batch.key(b)), b};
        std::sort(blocks.begin(), blocks.end());

        const FoldVersion& fold = foldForThisCpu();
        TreeWriter<Nodes> writer(nodes);
        // Whatever stops the update, nothing stale is kept.
        struct Guard {
            SaturationCache<Dim>& cache;
            bool done = false;
            ~Guard() {
                if (!done) cache.clear();
            }
        } guard{cache};
        for (const auto& [morton, b] : blocks) {
            const std::uint8_t* misses = batch.misses(b);
            const std::uint8_t* hits = batch.hits(b);
            BlockMask<Dim> touched;
            fold.touchedCells(BlockMask<Dim>::kWords, misses, hits, touched.words.data());
            BlockSaturation<Dim> block = saturation(batch.key(b), model.min());
            if (block.saturatedFree.all() && !hits) continue;  // misses change nothing
            writer.updateBlock(
                morton, touched, model.min(), block.saturatedFree, [&](int i, float value) {
                    return model.updated(value, misses[i], hits ? hits[i] : 0u, policy);
                });
            block.mayExceedUnknown |= hits != nullptr;
            cache.put(batch.key(b), block);
        }
        guard.done = true;
    }

    std::optional<float> logOdds(const Cell<Dim>& cell) const {
        if (!isAddressable(cell, kCellLimit)) return std::nullopt;
        const std::uint64_t morton = mortonOf<Dim>(blockOf<Dim>(cell));
        const int index = indexInBlock<Dim>(cell);
        Node node = nodes.root();
        for (int depth = 0; node != Nodes::kNull && nodes.hasChildren(node); ++depth)
            node = nodes.child(node, depth < kBlockDepth
                                         ? childTowards<Dim>(morton, depth)
                                         : childOfCell(index, kTreeDepth - 1 - depth));
        if (node == Nodes::kNull) return std::nullopt;
        return nodes.value(node);
    }

    void setLogOdds(const Cell<Dim>& cell, float value) {
        requireAddressableCell<Dim>(cell);
        value = storedValue(value);
        BlockMask<Dim> touched;
        touched.set(indexInBlock<Dim>(cell));
        write(blockOf<Dim>(cell), touched, [&](int, float) { return value; });
    }

    void setBlock(const BlockView<Dim>& view) {
        requireAddressableBlock<Dim>(view.key);
        std::array<float, kBlockCells<Dim>> values;
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (view.known.test(i))
                values[static_cast<std::size_t>(i)] = storedValue(view.values[i]);
        write(view.key, view.known,
              [&](int i, float) { return values[static_cast<std::size_t>(i)]; });
    }

    void forEachBlock(const typename OccupancyMap<Dim>::BlockVisitor& visit) const {
        if (const Node root = nodes.root(); root != Nodes::kNull) visitNode(root, 0, 0, visit);
    }

    bool visitBlock(const BlockKey<Dim>& key,
                    const typename OccupancyMap<Dim>::BlockVisitor& visit) const {
        if (!isAddressable(key, kBlockLimit)) return false;
        const std::uint64_t morton = mortonOf<Dim>(key);
        Node node = nodes.root();
        for (int depth = 0;
             node != Nodes::kNull && nodes.hasChildren(node) && depth < kBlockDepth; ++depth)
            node = nodes.child(node, childTowards<Dim>(morton, depth));
        if (node == Nodes::kNull) return false;
        Values values;
        BlockMask<Dim> known;
        readNode<kBlockBits>(node, 0, values, known);
        visit({key, values.data(), known});
        return true;
    }

    BlockSaturation<Dim> saturation(const BlockKey<Dim>& key, float lowerClamp) const {
        if (const auto* kept = cache.find(key, lowerClamp)) return *kept;
        BlockSaturation<Dim> result;
        if (!isAddressable(key, kBlockLimit)) return result;
        const std::uint64_t morton = mortonOf<Dim>(key);
        Node node = nodes.root();
        for (int depth = 0;
             node != Nodes::kNull && nodes.hasChildren(node) && depth < kBlockDepth; ++depth)
            node = nodes.child(node, childTowards<Dim>(morton, depth));
        if (node == Nodes::kNull) return result;
        markSaturated<kBlockBits>(node, 0, lowerClamp, result.saturatedFree);
        result.mayExceedUnknown = nodes.value(node) > 0;  // inner nodes have the highest
        return result;
    }

 private:
    using Values = std::array<float, kBlockCells<Dim>>;

    static int childOfCell(int index, int level) {
        int i = 0;
        for (int a = 0; a < Dim; ++a) i |= ((index >> (level + kBlockBits * a)) & 1) << a;
        return i;
    }

    template <typename Update>
    void write(const BlockKey<Dim>& key, const BlockMask<Dim>& touched, const Update& update) {
        cache.clear();
        TreeWriter<Nodes> writer(nodes);
        BlockMask<Dim> unused;
        writer.updateBlock(mortonOf<Dim>(key), touched, 0, unused, update);
    }

    template <int level>
    void markSaturated(Node node, int offset, float lowerClamp, BlockMask<Dim>& mask) const {
        if (!nodes.hasChildren(node)) {
            if (nodes.value(node) != lowerClamp) return;
            visitCube<Dim, level>(fullMask<Dim>(), offset, [&](int word, std::uint64_t bits) {
                mask.words[static_cast<std::size_t>(word)] |= bits;
            });
        } else if constexpr (level > 0) {
            for (int i = 0; i < 1 << Dim; ++i)
                if (const Node child = nodes.child(node, i); child != Nodes::kNull)
                    markSaturated<level - 1>(child, offset + childOffset<Dim>(i, level - 1),
                                             lowerClamp, mask);
        }
    }

    /// \param morton of the blocks below the node, its lower bits 0
    void visitNode(Node node, int depth, std::uint64_t morton,
                   const typename OccupancyMap<Dim>::BlockVisitor& visit) const {
        const int blockBits = Dim * (kBlockDepth - depth);
        Values values;
        if (!nodes.hasChildren(node)) {
            values.fill(nodes.value(node));
            for (std::uint64_t b = 0; b < std::uint64_t{1} << blockBits; ++b)
                visit({blockOfMorton<Dim>(morton + b), values.data(), fullMask<Dim>()});
        } else if (depth == kBlockDepth) {
            BlockMask<Dim> known;
            readNode<kBlockBits>(node, 0, values, known);
            visit({blockOfMorton<Dim>(morton), values.data(), known});
        } else {
            for (int i = 0; i < 1 << Dim; ++i)
                if (const Node child = nodes.child(node, i); child != Nodes::kNull)
                    visitNode(child, depth + 1,
                              morton + (static_cast<std::uint64_t>(i) << (blockBits - Dim)),
                              visit);
        }
    }

    template <int level>
    void readNode(Node node, int offset, Values& values, BlockMask<Dim>& known) const {
        if (!nodes.hasChildren(node)) {
            visitCube<Dim, level>(fullMask<Dim>(), offset, [&](int word, std::uint64_t bits) {
                known.words[static_cast<std::size_t>(word)] |= bits;
                for (; bits; bits &= bits - 1)
                    values[static_cast<std::size_t>(64 * word + __builtin_ctzll(bits))] =
                        nodes.value(node);
            });
        } else if constexpr (level > 0) {
            for (int i = 0; i < 1 << Dim; ++i)
                if (const Node child = nodes.child(node, i); child != Nodes::kNull)
                    readNode<level - 1>(child, offset + childOffset<Dim>(i, level - 1), values,
                                        known);
        }
    }
};

}  // namespace superray
