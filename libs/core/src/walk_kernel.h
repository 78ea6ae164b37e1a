#pragma once
// Ray walks into an update batch: one kernel per instruction set, equal cells.

#include <superray/core/ray_line.h>
#include <superray/core/scan_integrator.h>
#include <superray/core/traversal.h>
#include <superray/core/update_batch.h>

#include "block_directory.h"
#include "horizon_view.h"
#include "in_turns.h"
#include "point_kernels.h"
#include "ray_directions.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>
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
    /// Block -> where its counts are: offset / kBlockCells + 1 (bits 0..30).
    /// Number 1 is that of blocks without counts of their own.
    BlockDirectory<Dim> directory;
    UpdateBatch<Dim> batch;
    AddressBuffer addresses;
    std::uint64_t traversed = 0;

    void reset(const BlockBox<Dim>& box) {
        batch.clear();
        directory.reset(box);
        hitBlocks_.clear();
        listed_.clear();
        traversed = 0;
        map_ = nullptr;
    }
    /// From now on, new blocks start with the greatest count where the map is
    /// saturated free: more misses change nothing there, and a count tells both
    /// what the map and what this scan has saturated. Blocks that are saturated
    /// as a whole get no counts of their own.
    /// \param map nullptr: none; must outlive the scan
    void countMapSaturation(const SaturationSource<Dim>* map, const SensorModel& model,
                            UpdatePolicy policy) {
        map_ = map;
        lowerClamp_ = model.min();
        const bool once = policy == UpdatePolicy::oncePerScan;
        enough = once ? 1 : model.missesToSaturate();
        enoughUnknown = once ? 1 : model.missesToSaturateUnknown();
        sureHits_ = static_cast<std::uint8_t>(once ? 1 : model.hitsToSaturate());
    }
    /// Hit counts of a block, which is made on first use.
    std::uint8_t* hitsOf(const BlockKey<Dim>& key) { return hitsOf(batchBlock(key)); }
    /// The same of the block with this index in the directory, whose key is only asked
    /// for if it has no counts yet. \pre the directory is dense
    template <typename KeyOf>
    std::uint8_t* hitsOf(std::uint32_t index, const KeyOf& keyOf) {
        const std::uint32_t n = directory.data()[index] & ~kMayExceedUnknown;
        return hitsOf(n < kFirstBlock ? batchBlock(keyOf()) : n - kFirstBlock);
    }
    /// Whether more hits change nothing.
    bool sureHit(std::uint8_t hits) const { return hits >= sureHits_; }
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
            listed_[b] = false;
        }
        hitBlocks_.clear();
    }
    /// Misses beyond which more change nothing, in blocks whose number has the
    /// flag kMayExceedUnknown and in others.
    static constexpr std::uint32_t kMayExceedUnknown = std::uint32_t{1} << 31;
    /// Number of blocks that are saturated as a whole.
    static constexpr std::uint32_t kNoCounts = 1;
    std::uint32_t enough = 0, enoughUnknown = 0;
    float lowerClamp() const { return lowerClamp_; }

    /// Offset of a block's miss counts in the arena; the block is made on first use.
    std::uint32_t offsetOf(const BlockKey<Dim>& key) { return offset(numberOf(key)); }
    /// The block's number in the directory, made on first use.
    std::uint32_t numberOf(const BlockKey<Dim>& key) {
        const std::uint32_t n = directory.number(key);
        return n != 0 ? n : makeBlock(key);
    }
    /// Offset of the counts that a directory number stands for (the flag drops
    /// out of the product). \pre number != 0
    static std::uint32_t offset(std::uint32_t number) {
        return (number - 1) * static_cast<std::uint32_t>(kBlockCells<Dim>);
    }
    /// Batch block of a block with counts of its own; nothing for others.
    std::optional<std::uint32_t> ownBatchBlock(const BlockKey<Dim>& key) const {
        const std::uint32_t n = directory.number(key) & ~kMayExceedUnknown;
        if (n < kFirstBlock) return std::nullopt;
        return n - kFirstBlock;
    }
    /// Batch block of a block, which gets counts of its own if it had none.
    std::uint32_t batchBlock(const BlockKey<Dim>& key) {
        std::uint32_t n = numberOf(key) & ~kMayExceedUnknown;
        if (n == kNoCounts) {
            const std::uint32_t block = batch.addBlock(key);
            std::uint8_t* counts = batch.missesOf(block);
            std::fill(counts, counts + kBlockCells<Dim>,
                      std::uint8_t{UpdateBatch<Dim>::kMaxCount});
            directory.setNumber(key, n = block + kFirstBlock);
        }
        return n - kFirstBlock;
    }
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
    static constexpr std::uint32_t kFirstBlock = 2;

    /// Hit counts of a block of the batch.
    std::uint8_t* hitsOf(std::uint32_t block) {
        if (block >= listed_.size()) listed_.resize(batch.blockCount());
        if (!listed_[block]) hitBlocks_.push_back(block);
        listed_[block] = true;
        return batch.hitsOf(block);
    }
    std::uint32_t makeBlock(const BlockKey<Dim>& key) {
        BlockSaturation<Dim> before;
        if (map_ != nullptr) before = map_->saturation(key, lowerClamp_);
        if (before.saturatedFree.all()) {
            directory.setNumber(key, kNoCounts);
            return kNoCounts;
        }
        const std::uint32_t block = batch.addBlock(key);
        if (before.saturatedFree.any()) {
            std::uint8_t* counts = batch.missesOf(block);
            for (int row = 0; row < kBlockCells<Dim> / 8; ++row)
                spreadBits(before.saturatedFree.words[row / 8] >> (8 * (row % 8)),
                           counts + 8 * row);
        }
        const std::uint32_t number =
            (block + kFirstBlock) | (before.mayExceedUnknown ? kMayExceedUnknown : 0);
        directory.setNumber(key, number);
        return number;
    }
    /// Bytes of 255 where the low 8 bits are set.
    static void spreadBits(std::uint64_t bits, std::uint8_t* bytes) {
        constexpr std::uint64_t kEach = 0x0101010101010101;
        // Bit i to byte i, then any set bit of a byte to all of its bits.
        const std::uint64_t one = ((bits & 0xFF) * kEach & 0x8040201008040201);
        const std::uint64_t set = ((one + 0x7F7F7F7F7F7F7F7F) | one) >> 7 & kEach;
        const std::uint64_t all = set * 255;
        std::memcpy(bytes, &all, sizeof all);
    }

    const SaturationSource<Dim>* map_ = nullptr;
    float lowerClamp_ = 0;
    std::uint8_t sureHits_ = 0;
    std::vector<std::uint32_t> hitBlocks_;  // got hits since settleSureHits()
    std::vector<bool> listed_;              // there, per block of the batch
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
