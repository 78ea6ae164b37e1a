// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Stage 1 of empty-space skipping: where each ray goes, and in which slice it ends.

#include "directions/classified_batch.h"
#include "memory/scratch_array.h"

#include <cstdint>

namespace superray {

/// Rays [first, last) of a scan: the part of it that one thread answers for.
struct RayChunk {
    std::size_t first = 0, last = 0;
    std::size_t size() const { return last - first; }
};

/// Direction and length of every ray of a chunk. Ray i is the i-th of the chunk.
template <int Dim>
class ClassifiedRays {
 public:
    /// Makes room for `count` rays, still to be classified. Keeps its memory.
    void reset(const DirectionBins<Dim>& bins, std::size_t count) {
        bins_ = bins;
        size_ = count;
        subBin_.reserve(count + ClassifiedBatch<Dim>::kSlack);
        lastSlice_.reserve(count + ClassifiedBatch<Dim>::kSlack);
    }

    std::size_t size() const { return size_; }
    const DirectionBins<Dim>& bins() const { return bins_; }
    /// Direction of a ray; see DirectionBins.
    std::uint32_t subBin(std::size_t ray) const { return subBin_[ray]; }
    /// Slice in which a ray ends.
    std::int32_t lastSlice(std::size_t ray) const { return lastSlice_[ray]; }
    bool unclassified(std::size_t ray) const {
        return DirectionBins<Dim>::binOf(subBin_[ray]) == bins_.unclassified();
    }
    /// Takes a ray that was walked early out of all later choices.
    void markFinished(std::size_t ray) { subBin_[ray] = bins_.firstSubBin(bins_.finished()); }

    /// Per ray, with ClassifiedBatch::kSlack more, for kernels.
    std::uint32_t* subBins() { return subBin_.data(); }
    const std::uint32_t* subBins() const { return subBin_.data(); }
    std::uint16_t* lastSlices() { return lastSlice_.data(); }
    const std::uint16_t* lastSlices() const { return lastSlice_.data(); }

 private:
    DirectionBins<Dim> bins_;
    std::size_t size_ = 0;
    ScratchArray<std::uint32_t> subBin_;
    ScratchArray<std::uint16_t> lastSlice_;
};

}  // namespace superray
