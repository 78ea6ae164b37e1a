#pragma once
// Ray walks into an update batch: one kernel per instruction set, equal cells.

#include <superray/core/ray_line.h>
#include <superray/core/scan_integrator.h>
#include <superray/core/traversal.h>
#include <superray/core/update_batch.h>

#include "block_directory.h"

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
    BlockDirectory<Dim> directory;  // block -> 1 + batch block
    UpdateBatch<Dim> batch;
    AddressBuffer addresses;
    std::uint64_t traversed = 0;

    void reset(const BlockBox<Dim>& box) {
        batch.clear();
        directory.reset(box);
        traversed = 0;
        map_ = nullptr;
    }
    /// From now on, new blocks start with the greatest count where the map is
    /// saturated free: more misses change nothing there, and a count tells both
    /// what the map and what this scan has saturated.
    /// \param map nullptr: none; must outlive the scan
    void countMapSaturation(const SaturationSource<Dim>* map, float lowerClamp) {
        map_ = map;
        lowerClamp_ = lowerClamp;
    }
    /// Misses of a cell counted so far (after flush()).
    std::uint32_t misses(const Cell<Dim>& cell) {
        return batch.missesOf(blockNumber(blockOf<Dim>(cell)))[indexInBlock<Dim>(cell)];
    }
    /// Batch block of a block, made on first use.
    std::uint32_t blockNumber(const BlockKey<Dim>& key) {
        const std::uint32_t n = directory.number(key);
        return n != 0 ? n - 1 : makeBlock(key);
    }
    /// Adds `weight` to every address and forgets them.
    void flush(std::uint32_t weight) {
        std::uint8_t* counts = batch.missArena();
        traversed += addresses.size();
        const std::uint32_t* const end = addresses.end();
        if (weight == 1) {
            for (const std::uint32_t* a = addresses.begin(); a != end; ++a) {
                const unsigned c = counts[*a];
                counts[*a] = static_cast<std::uint8_t>(c + (c != 255));
            }
        } else {
            for (const std::uint32_t* a = addresses.begin(); a != end; ++a)
                counts[*a] = saturatingAdd(counts[*a], weight);
        }
        addresses.clear();
    }

    static std::uint8_t saturatingAdd(std::uint8_t count, std::uint32_t weight) {
        constexpr std::uint32_t kMax = UpdateBatch<Dim>::kMaxCount;
        return static_cast<std::uint8_t>(weight > kMax - count ? kMax : count + weight);
    }
    std::uint32_t makeBlock(const BlockKey<Dim>& key) {
        const std::uint32_t block = batch.addBlock(key);
        directory.setNumber(key, block + 1);
        if (map_ != nullptr) {
            if (const BlockMask<Dim>* saturated = map_->saturatedFree(key, lowerClamp_)) {
                std::uint8_t* counts = batch.missesOf(block);
                for (int i = 0; i < kBlockCells<Dim>; ++i)
                    if (saturated->test(i)) counts[i] = UpdateBatch<Dim>::kMaxCount;
            }
        }
        return block;
    }

 private:
    const SaturationSource<Dim>* map_ = nullptr;
    float lowerClamp_ = 0;
};

/// Appends the free cells of a ray in the slices [from, to).
/// \pre state.addresses.reserveMore(line.steps()) was called
template <int Dim>
using WalkKernel = void (*)(WalkState<Dim>& state, const RayLine<Dim>& line, std::int32_t from,
                            std::int32_t to);

/// The portable kernel; also serves directories that are not dense.
template <int Dim>
void walkPortable(WalkState<Dim>& state, const RayLine<Dim>& line, std::int32_t from,
                  std::int32_t to);

/// 8 slices at once; need a dense directory and the processor for it.
template <int Dim>
void walkAvx2(WalkState<Dim>& state, const RayLine<Dim>& line, std::int32_t from,
              std::int32_t to);
template <int Dim>
void walkAvx512(WalkState<Dim>& state, const RayLine<Dim>& line, std::int32_t from,
                std::int32_t to);

/// The fastest kernel of this processor. The environment variable
/// SUPERRAY_INSTRUCTION_SET = portable | avx2 | avx512 asks for a lesser one.
template <int Dim>
WalkKernel<Dim> bestWalkKernel();

}  // namespace superray
