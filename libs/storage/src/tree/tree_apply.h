// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file tree_apply.h
/// An update batch into a tree, in one or several threads.

#include <superray/core/detail/parallel.h>
#include <superray/core/update_batch.h>

#include "tree/saturation_cache.h"
#include "tree/tree_read.h"
#include "tree/tree_update.h"
#include "values/fold_layers.h"

#include <algorithm>
#include <atomic>
#include <deque>
#include <vector>

namespace superray {

/// Folds the blocks of a batch into a tree. Threads work below different nodes,
/// each with an editor of its own; what is above these nodes is left to one
/// thread. The tree does not depend on the number of threads.
template <typename Nodes>
class TreeApply {
 public:
    static constexpr int Dim = Nodes::kDim;
    using Node = typename Nodes::Node;
    using Editor = typename Nodes::Editor;
    using Writer = TreeWriter<Nodes>;

    /// \param blocks scratch of any contents
    TreeApply(Nodes& nodes, SaturationCache<Dim>& cache, std::vector<OrderedBlock> (&blocks)[2],
              const UpdateBatch<Dim>& batch, const SensorModel& model, UpdatePolicy policy)
        : nodes_(nodes),
          cache_(cache),
          blocks_(blocks[0]),
          batch_(batch),
          model_(model, policy),
          fold_(foldForThisCpu()) {
        const std::size_t n = batch.blockCount();
        cache.startScan(model.min(), n);
        // In the order of the tree, so that neighbours share the way down.
        blocks_.resize(n);
        for (std::size_t b = 0; b < n; ++b)
            blocks_[b] = {mortonOf<Dim>(batch.key(b)), static_cast<std::uint32_t>(b), 0};
        sortBlocks(blocks_, blocks[1]);
        for (OrderedBlock& b : blocks_) b.entry = cache.entryOf(batch.key(b.number));
    }

    /// \pre the nodes keep room for what this makes
    /// \throws std::bad_alloc, and changes nothing then
    void run(unsigned threads) {
        const std::size_t shares =
            chunkCountFor(blocks_.size(), kBlocksPerChunk, Nodes::kParallel ? threads : 1);
        if constexpr (Nodes::kParallel) {
            if (shares > 1) return runParallel(shares);
        }
        Editor editor(nodes_);
        Writer writer(nodes_, editor);
        applyBlocks(writer, editor, 0, blocks_.size());
    }

 private:
    /// Blocks that repay a thread.
    static constexpr std::size_t kBlocksPerChunk = 512;
    /// Of the nodes that threads share out: cubes of 8 blocks per axis are many
    /// in a scan, and hold many blocks each.
    static constexpr int kSplitDepth = kBlockDepth - 3;

    /// The blocks below one node.
    struct Subtree {
        std::size_t first, last;
        Node top;          ///< kNull: there is none yet
        bool isBelowLeaf;  ///< of a leaf that is larger than the subtree
    };

    void runParallel(std::size_t shares) {
        std::vector<Subtree> subtrees;
        Editor topEditor(nodes_);
        Writer topWriter(nodes_, topEditor);
        for (std::size_t b = 0; b < blocks_.size();) {
            Subtree s{b, b, Nodes::kNull, false};
            const auto number = [&](std::size_t i) {
                return blocks_[i].morton >> (Dim * (kBlockDepth - kSplitDepth));
            };
            while (s.last < blocks_.size() && number(s.last) == number(b)) ++s.last;
            s.top = topWriter.find(blocks_[b].morton, kSplitDepth, s.isBelowLeaf);
            subtrees.push_back(s);
            b = s.last;
        }
        topEditor.reserveWays(subtrees.size());  // to new subtrees
        std::deque<Editor> editors;
        for (std::size_t s = 0; s < shares; ++s) editors.emplace_back(nodes_);

        std::atomic<std::size_t> next{0};
        inParallel(shares, [&](std::size_t share) {
            for (std::size_t i; (i = next++) < subtrees.size();) {
                Subtree& s = subtrees[i];
                if (s.isBelowLeaf) continue;
                Writer writer(nodes_, editors[share], s.top, kSplitDepth);
                applyBlocks(writer, editors[share], s.first, s.last);
                s.top = writer.finish();
            }
        });
        for (const Subtree& s : subtrees)
            if (s.top != Nodes::kNull)
                topWriter.attach(blocks_[s.first].morton, kSplitDepth, s.top);
        topWriter.finish();
        // What is below a large leaf would split it for all.
        for (const Subtree& s : subtrees)
            if (s.isBelowLeaf) applyBlocks(topWriter, topEditor, s.first, s.last);
    }

    void applyBlocks(Writer& writer, Editor& editor, std::size_t first, std::size_t last) {
        for (std::size_t b = first; b < last; ++b) applyBlock(writer, editor, blocks_[b]);
    }

    void applyBlock(Writer& writer, Editor& editor, const OrderedBlock& block) {
        using Found = typename Writer::Found;
        const std::uint8_t* const misses = batch_.misses(block.number);
        const std::uint8_t* const hits = batch_.hits(block.number);
        BlockMask<Dim> touched;
        fold_.touchedCells(BlockMask<Dim>::kWords, misses, hits, touched.words.data());

        auto saturation = cache_.get(batch_.key(block.number), block.entry);
        Found found = Found::nothing;
        if (!saturation) {
            found = writer.enter(block.morton);
            saturation = found == Found::nothing
                             ? BlockSaturation<Dim>{}
                             : saturationOfBlock(nodes_, writer.node(), model_.min);
        }
        leaveOutSaturated<Dim>(fold_, touched, saturation->saturatedFree, hits);
        if (touched.any()) {
            found = writer.enter(block.morton);
            editor.reserve();
            fold(writer, found, touched, misses, hits, saturation->saturatedFree);
            saturation->mayExceedUnknown |= hits != nullptr;
        }
        cache_.put(block.entry, *saturation);
    }

    void fold(Writer& writer, typename Writer::Found found, const BlockMask<Dim>& touched,
              const std::uint8_t* misses, const std::uint8_t* hits,
              BlockMask<Dim>& saturated) const {
        typename Writer::Values values;
        writer.read(found, touched, values);
        constexpr int kLayers = BlockMask<Dim>::kWords;
        float* layers[kLayers];
        for (int z = 0; z < kLayers; ++z) layers[z] = values.data() + 64 * z;
        BlockMask<Dim> known, saturatedNow;  // of touched cells only
        fold_.foldCounts(model_,
                         {kLayers, layers, touched.words.data(), known.words.data(),
                          saturatedNow.words.data()},
                         misses, hits);
        writer.write(found, touched, values);
        for (std::size_t w = 0; w < saturated.words.size(); ++w)
            saturated.words[w] =
                (saturated.words[w] & ~touched.words[w]) | saturatedNow.words[w];
    }

    Nodes& nodes_;
    SaturationCache<Dim>& cache_;
    std::vector<OrderedBlock>& blocks_;
    const UpdateBatch<Dim>& batch_;
    const FoldModel model_;
    const FoldVersion& fold_;
};

}  // namespace superray
