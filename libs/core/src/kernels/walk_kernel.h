#pragma once
// Ray walks into an update batch: one kernel per instruction set, equal cells.

#include <superray/core/ray_line.h>
#include <superray/core/scan_integrator.h>
#include <superray/core/traversal.h>
#include <superray/core/update_batch.h>

#include "counting/block_directory.h"
#include "skipping/horizon_view.h"
#include "threads/in_turns.h"
#include "kernels/point_kernels.h"
#include "directions/ray_directions.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace superray {

/// Addresses of free cells waiting to be counted: offsets into miss counts.
class AddressBuffer {
 public:
    /// Room for `n` more, and for a vector register beyond.
    void reserveMore(std::size_t n) {
        if (size_ + n + kSlack > storage_.size()) storage_.resize(2 * (size_ + n + kSlack));
    }
    /// \pre reserved
    void push(std::uint32_t address) { storage_[size_++] = address; }
    std::uint32_t* end() { return storage_.data() + size_; }
    void setEnd(const std::uint32_t* end) {
        size_ = static_cast<std::size_t>(end - storage_.data());
    }
    const std::uint32_t* begin() const { return storage_.data(); }
    std::size_t size() const { return size_; }
    void clear() { size_ = 0; }

 private:
    static constexpr std::size_t kSlack = 16;
    std::vector<std::uint32_t> storage_;
    std::size_t size_ = 0;
};

/// What one thread writes to. Kernels append addresses of free cells (offsets
/// into the batch's miss counts) to `addresses`; flush() counts them.
template <int Dim>
struct WalkState {
    /// Block -> its index in the batch + 1.
    BlockDirectory<Dim> directory;
    UpdateBatch<Dim> batch;
    AddressBuffer addresses;
    std::uint64_t traversed = 0;

    void reset(const BlockBox<Dim>& box) {
        batch.clear();
        directory.reset(box);
        hitBlocks_.clear();
        hitPlaces_.clear();
        traversed = 0;
    }
    /// From how many hits on more of them, and misses, change nothing.
    /// \pre at most 255
    void setSureHits(std::uint32_t hits) { sureHits_ = static_cast<std::uint8_t>(hits); }
    /// Place of a block's hit counts in the arena; the block is made on first use.
    std::uint32_t hitPlace(const BlockKey<Dim>& key) { return placeHits(batchBlock(key)); }
    /// The same of the block with this index in the directory, whose key is only asked
    /// for if it got no hits yet. \pre the directory is dense
    template <typename KeyOf>
    std::uint32_t hitPlace(std::uint32_t index, const KeyOf& keyOf) {
        const std::uint32_t n = directory.data()[index];
        if (n < hitPlaces_.size() && hitPlaces_[n] != kNoPlace) return hitPlaces_[n];
        return placeHits(n == 0 ? batchBlock(keyOf()) : n - 1);
    }
    std::uint8_t sureHits() const { return sureHits_; }
    /// No place in the arena.
    static constexpr std::uint32_t kNoPlace = ~std::uint32_t{0};
    /// Cells with so many hits that they end up at the upper clamp (with
    /// oncePerScan, with any) need no misses any more: they get the greatest miss
    /// count, so that no walk need bother.
    void settleSureHits() {
        for (const std::uint32_t b : hitBlocks_) {
            const std::uint8_t* const hits = batch.hits(b);
            std::uint8_t* const misses = batch.missesOf(b);
            for (int i = 0; i < kBlockCells<Dim>; ++i)
                misses[i] = hits[i] >= sureHits_ ? std::uint8_t{UpdateBatch<Dim>::kMaxCount}
                                                 : misses[i];
            hitPlaces_[b + 1] = kNoPlace;
        }
        hitBlocks_.clear();
    }
    /// Offset of a block's miss counts in the arena; the block is made on first use.
    std::uint32_t offsetOf(const BlockKey<Dim>& key) { return offset(numberOf(key)); }
    /// The block's number in the directory, made on first use.
    std::uint32_t numberOf(const BlockKey<Dim>& key) {
        const std::uint32_t n = directory.number(key);
        if (n != 0) return n;
        const std::uint32_t made = batch.addBlock(key) + 1;
        directory.setNumber(key, made);
        return made;
    }
    /// Offset of the counts that a directory number stands for. \pre number != 0
    static std::uint32_t offset(std::uint32_t number) {
        return (number - 1) * static_cast<std::uint32_t>(kBlockCells<Dim>);
    }
    /// Batch block of a block with counts; nothing for others.
    std::optional<std::uint32_t> ownBatchBlock(const BlockKey<Dim>& key) const {
        const std::uint32_t n = directory.number(key);
        if (n == 0) return std::nullopt;
        return n - 1;
    }
    /// Batch block of a block, made on first use.
    std::uint32_t batchBlock(const BlockKey<Dim>& key) { return numberOf(key) - 1; }
    /// Adds `weight` to every address and forgets them.
    void flush(std::uint32_t weight) {
        std::uint8_t* counts = batch.missArena();
        traversed += addresses.size();
        const std::uint32_t* const at = addresses.begin();
        if (weight == 1) {
            // Rays side by side visit the same cells one after the other.
            inTurns(addresses.size(), [&](std::size_t, std::size_t i) {
                std::uint8_t& count = counts[at[i]];
                std::uint8_t more;
                // Two instructions: the carry is taken off again.
                const bool carry = __builtin_add_overflow(count, std::uint8_t{1}, &more);
                count = static_cast<std::uint8_t>(more - carry);
            });
        } else {
            for (std::size_t i = 0, n = addresses.size(); i < n; ++i)
                counts[at[i]] = saturatingAdd(counts[at[i]], weight);
        }
        addresses.clear();
    }

    static std::uint8_t saturatingAdd(std::uint8_t count, std::uint32_t weight) {
        constexpr std::uint32_t kMax = UpdateBatch<Dim>::kMaxCount;
        return static_cast<std::uint8_t>(weight > kMax - count ? kMax : count + weight);
    }

 private:
    std::uint32_t placeHits(std::uint32_t block) {
        if (block + 1 >= hitPlaces_.size()) hitPlaces_.resize(batch.blockCount() + 1, kNoPlace);
        std::uint32_t& place = hitPlaces_[block + 1];
        if (place == kNoPlace) {
            hitBlocks_.push_back(block);
            place = static_cast<std::uint32_t>(batch.hitsOf(block) - batch.hitArena());
        }
        return place;
    }

    std::uint8_t sureHits_ = 0;
    std::vector<std::uint32_t> hitBlocks_;  // got hits since settleSureHits()
    std::vector<std::uint32_t> hitPlaces_;  // of these, by number in the directory
};

/// Appends the free cells of a ray from slice `from` on.
/// \pre state.addresses.reserveMore(line.steps()) was called
template <int Dim>
using WalkKernel = void (*)(WalkState<Dim>& state, const RayLine<Dim>& line, std::int32_t from);

/// Up to 8 rays of one kind (RayDirections) from the common origin.
struct RayLanes {
    std::uint32_t kind = 0;
    int count = 0;
    alignas(32) std::uint32_t ray[8] = {};  ///< numbers; of unused lanes: any
    alignas(32) std::int32_t from[8] = {};  ///< slices to begin with
};

/// Appends the free cells of some rays. \pre count > 0
template <int Dim>
using WalkRays = void (*)(WalkState<Dim>& state, const RayBundle<Dim>& rays,
                          const RayLanes& lanes);

/// Which of the counts of a block are at least `least`, 1 <= least <= 255.
template <int Dim>
using AtLeast = BlockMask<Dim> (*)(const std::uint8_t* counts, std::uint32_t least);

/// What exists per instruction set.
template <int Dim>
struct WalkKernels {
    WalkKernel<Dim> walk;
    WalkRays<Dim> walkRays;
    WalkRays<Dim> walkEnds;  ///< the same, faster for few slices. \pre all from > 0
    FindDirections<Dim> findDirections;
    FindRuns<Dim> findRuns;
    ChooseRays chooseRays;
    AtLeast<Dim> atLeast;
    NoteOpen<Dim> noteOpen;
    CopyPoints<Dim, float> copyFloats;
    CopyPoints<Dim, double> copyDoubles;

    CopyPoints<Dim, float> copy(float) const { return copyFloats; }
    CopyPoints<Dim, double> copy(double) const { return copyDoubles; }
};

/// The free cells in the slices [from, to), for any instruction set.
template <int Dim>
void walkPortable(WalkState<Dim>& state, const RayLine<Dim>& line, std::int32_t from,
                  std::int32_t to);
/// Those of a ray of the common origin, from slice `from` on.
template <int Dim>
void walkPortable(WalkState<Dim>& state, const RayBundle<Dim>& rays, std::size_t ray,
                  std::int32_t from);
/// The portable kernels also serve directories that are not dense.
template <int Dim>
WalkKernels<Dim> portableKernels();

/// 8 slices (rays) at once; walks need a dense directory.
/// \pre the processor has the instructions
template <int Dim>
WalkKernels<Dim> avx2Kernels();
template <int Dim>
WalkKernels<Dim> avx512Kernels();

/// The fastest kernels of this processor. The environment variable
/// SUPERRAY_INSTRUCTION_SET = portable | avx2 | avx512 asks for lesser ones.
template <int Dim>
WalkKernels<Dim> bestKernels();

}  // namespace superray
