// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file tree_storage.h
/// All that Octree and Quadtree do, over the nodes of either.

#include "tree/saturation_cache.h"
#include "tree/tree_apply.h"
#include "tree/tree_forget.h"
#include "tree/tree_growth.h"
#include "tree/tree_read.h"
#include "tree/tree_update.h"
#include "values/saturation_clamp.h"
#include "values/value_rules.h"

#include <superray/storage/occupancy_map.h>

#include <optional>
#include <vector>

namespace superray {

template <typename Nodes>
class TreeStorage {
 public:
    static constexpr int Dim = Nodes::kDim;
    using Node = typename Nodes::Node;
    using WrittenBlocks = typename OccupancyMap<Dim>::WrittenBlocks;

    template <typename... Args>
    explicit TreeStorage(const Args&... args) : nodes(args...) {}

    Nodes nodes;
    SaturationCache<Dim> cache;

    /// \pre there is room for what this makes, see keepRoomFor()
    /// \throws std::bad_alloc, and changes nothing then
    void apply(const UpdateBatch<Dim>& batch, const SensorModel& model, UpdatePolicy policy,
               unsigned threads) {
        // Whatever stops the update, nothing stale is kept.
        struct Guard {
            SaturationCache<Dim>& cache;
            bool done = false;
            ~Guard() {
                if (!done) cache.clear();
            }
        } guard{cache};
        TreeApply<Nodes>(nodes, cache, blocks_, batch, model, policy).run(threads);
        guard.done = true;
    }

    // See OccupancyMap.
    void keepRoomFor(std::size_t blocks, unsigned threads) {
        nodes.keepRoom(Nodes::growthAtMost(blocks), threads);
    }
    void keepRoomFor(const WrittenBlocks& written) { nodes.keepRoom(growthBy(written), 1); }

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
        Values values;
        values[static_cast<std::size_t>(indexInBlock<Dim>(cell))] = value;
        write(blockOf<Dim>(cell), touched, values);
    }

    void setBlock(const BlockView<Dim>& view) {
        requireAddressableBlock<Dim>(view.key);
        Values values;
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (view.known.test(i))
                values[static_cast<std::size_t>(i)] = storedValue(view.values[i]);
        write(view.key, view.known, values);
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
        readNode<kBlockBits>(nodes, node, 0, values.data(), known);
        visit({key, values.data(), known});
        return true;
    }

    void forgetOutside(const BlockWindow<Dim>& window,
                       const typename OccupancyMap<Dim>::KeyVisitor& forgotten) {
        try {
            TreeForget<Nodes>(nodes, window, [&](const BlockKey<Dim>& key) {
                cache.forget(key);
                forgotten(key);
            }).run();
        } catch (...) {
            cache.clear();
            throw;
        }
    }

    TreeGrowth growthBy(const WrittenBlocks& written) const {
        GrowthCount<Nodes> count(nodes);
        written([&](const BlockView<Dim>& block) { count.add(block); });
        return count.result();
    }

    BlockSaturation<Dim> saturation(const BlockKey<Dim>& key, float lowerClamp) const {
        if (const auto kept = cache.find(key, lowerClamp)) return *kept;
        if (!isAddressable(key, kBlockLimit)) return {};
        const std::uint64_t morton = mortonOf<Dim>(key);
        Node node = nodes.root();
        for (int depth = 0;
             node != Nodes::kNull && nodes.hasChildren(node) && depth < kBlockDepth; ++depth)
            node = nodes.child(node, childTowards<Dim>(morton, depth));
        if (node == Nodes::kNull) return {};
        return saturationOfBlock(nodes, node, lowerClamp);
    }

 private:
    using Values = std::array<float, kBlockCells<Dim>>;

    static int childOfCell(int index, int level) {
        int i = 0;
        for (int a = 0; a < Dim; ++a) i |= ((index >> (level + kBlockBits * a)) & 1) << a;
        return i;
    }

    /// \param values of touched cells
    void write(const BlockKey<Dim>& key, const BlockMask<Dim>& touched, const Values& values) {
        if (!touched.any()) return;
        cache.clear();
        typename Nodes::Editor editor(nodes);
        editor.reserve();
        TreeWriter<Nodes> writer(nodes, editor);
        const auto found = writer.enter(mortonOf<Dim>(key));
        Values all;
        writer.read(found, touched, all);
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (touched.test(i))
                all[static_cast<std::size_t>(i)] = values[static_cast<std::size_t>(i)];
        writer.write(found, touched, all);
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
            readNode<kBlockBits>(nodes, node, 0, values.data(), known);
            visit({blockOfMorton<Dim>(morton), values.data(), known});
        } else {
            for (int i = 0; i < 1 << Dim; ++i)
                if (const Node child = nodes.child(node, i); child != Nodes::kNull)
                    visitNode(child, depth + 1,
                              morton + (static_cast<std::uint64_t>(i) << (blockBits - Dim)),
                              visit);
        }
    }

    std::vector<OrderedBlock> blocks_[2];  // scratch of apply()
};

}  // namespace superray
