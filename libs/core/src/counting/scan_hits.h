// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Hits of a whole scan, which several threads have counted, each for itself.

#include "counting/scan_counts.h"

#include <algorithm>
#include <array>
#include <vector>

namespace superray {

/// Where one thread has counted hits. Does not change while walks count misses, so other
/// threads may read it then.
template <int Dim>
class HitBlocks {
 public:
    /// Takes note of the blocks with hits. \pre all hits of the thread are counted
    void assign(const ScanCounts<Dim>& counts) {
        directory_.reset(counts.directory.box());
        hits_.clear();
        for (std::size_t b = 0; b < counts.batch.blockCount(); ++b) {
            const std::uint8_t* const hits = counts.batch.hits(b);
            if (hits == nullptr) continue;
            hits_.push_back(hits);
            directory_.setId(counts.batch.key(b), static_cast<std::uint32_t>(hits_.size()));
        }
    }
    /// Counts of the cells of a block; nullptr: none.
    const std::uint8_t* hits(const BlockKey<Dim>& key) const {
        const std::uint32_t id = directory_.id(key);
        return id == 0 ? nullptr : hits_[id - 1];
    }

 private:
    BlockDirectory<Dim> directory_;  // block -> 1 + index
    std::vector<const std::uint8_t*> hits_;
};

/// Hits that each thread of a scan has counted.
template <int Dim>
class ScanHits {
 public:
    using Counts = std::array<std::uint8_t, kBlockCells<Dim>>;

    void clear() { threads_.clear(); }
    /// \param blocks of one more thread; must not move or change while this is used
    void add(const HitBlocks<Dim>& blocks) { threads_.push_back(&blocks); }

    /// Sums up the hits of the cells of a block, cut at 255.
    /// \param sum overwritten, where there are hits
    /// \return the counts; nullptr if no ray ends in the block
    const std::uint8_t* hits(const BlockKey<Dim>& key, Counts& sum) const {
        const std::uint8_t* found = nullptr;
        for (const HitBlocks<Dim>* const thread : threads_) {
            const std::uint8_t* const more = thread->hits(key);
            if (more == nullptr) continue;
            if (found == nullptr) {
                found = more;
                continue;
            }
            if (found != sum.data()) std::copy_n(found, sum.size(), sum.data());
            found = sum.data();
            for (std::size_t i = 0; i < sum.size(); ++i)
                sum[i] = ScanCounts<Dim>::saturatingAdd(sum[i], more[i]);
        }
        return found;
    }

 private:
    std::vector<const HitBlocks<Dim>*> threads_;
};

}  // namespace superray
