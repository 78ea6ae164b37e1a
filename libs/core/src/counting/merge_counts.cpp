// SPDX-License-Identifier: BSD-3-Clause
#include "counting/merge_counts.h"

#include <superray/core/detail/parallel.h>

#include "tuning.h"

#include <vector>

namespace superray {
namespace {

/// Adds the counts of a block, saturating.
template <int Dim>
void add(std::uint8_t* sum, const std::uint8_t* more) {
    for (int i = 0; i < kBlockCells<Dim>; ++i) {
        const auto s = static_cast<std::uint8_t>(sum[i] + more[i]);
        sum[i] = s < more[i] ? std::uint8_t{255} : s;
    }
}

}  // namespace

/// Blocks that both have are added in threads. Those that need memory come last, in one.
template <int Dim>
void mergeCounts(ScanCounts<Dim>& to, const ScanCounts<Dim>& from, NewBlocks newBlocks,
                 std::size_t threads) {
    const std::size_t blocks = from.batch.blockCount();
    const std::size_t chunks = chunkCountFor(blocks, CountingCosts::kBlocksPerChunk, threads);
    const auto addTo = [&](std::uint32_t own, std::size_t b) {
        add<Dim>(to.batch.missesOf(own), from.batch.misses(b));
        if (const std::uint8_t* const hits = from.batch.hits(b))
            add<Dim>(to.batch.hitsOf(own), hits);
    };
    std::vector<std::vector<std::size_t>> left(chunks);
    inParallel(chunks, [&](std::size_t chunk) {
        const std::size_t end = chunkBegin(blocks, chunk + 1, chunks);
        for (std::size_t b = chunkBegin(blocks, chunk, chunks); b < end; ++b) {
            const auto own = to.ownBatchBlock(from.batch.key(b));
            if (own && (from.batch.hits(b) == nullptr || to.batch.hits(*own) != nullptr))
                addTo(*own, b);
            else
                left[chunk].push_back(b);
        }
    });
    for (const auto& some : left)
        for (const std::size_t b : some) {
            const BlockKey<Dim>& key = from.batch.key(b);
            if (newBlocks == NewBlocks::copied || to.ownBatchBlock(key))
                addTo(to.batchBlock(key), b);
            else
                to.batch.borrowBlock(key, from.batch.misses(b), from.batch.hits(b));
        }
    to.traversed += from.traversed;
}

template void mergeCounts(ScanCounts<2>&, const ScanCounts<2>&, NewBlocks, std::size_t);
template void mergeCounts(ScanCounts<3>&, const ScanCounts<3>&, NewBlocks, std::size_t);

}  // namespace superray
