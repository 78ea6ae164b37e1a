// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/update_batch.h>

#include <stdexcept>

namespace superray {

template <int Dim>
BlockMask<Dim> UpdateBatch<Dim>::touched(std::size_t block) const {
    BlockMask<Dim> mask;
    const std::uint8_t* m = misses(block);
    const std::uint8_t* h = hits(block);
    for (int i = 0; i < kCells; ++i)
        if (m[i] != 0 || (h != nullptr && h[i] != 0)) mask.set(i);
    return mask;
}

template <int Dim>
std::uint32_t UpdateBatch<Dim>::addBlock(const BlockKey<Dim>& key) {
    const std::size_t block = keys_.size();
    // Cells are addressed by 32-bit offsets into the miss counts.
    if (block + 1 >= (std::uint64_t{1} << 32) / kCells)
        throw std::length_error("scan touches more than 2^32 cells");
    keys_.push_back(key);
    hitSlots_.push_back(-1);
    misses_.append(kCells);
    return static_cast<std::uint32_t>(block);
}

template <int Dim>
std::uint8_t* UpdateBatch<Dim>::hitsOf(std::uint32_t block) {
    if (hitSlots_[block] < 0) {
        hitSlots_[block] = static_cast<std::int32_t>(hits_.size() / kCells);
        hits_.append(kCells);
    }
    return hits_.data() + hitSlot(block);
}

template <int Dim>
void UpdateBatch<Dim>::clear() {
    keys_.clear();
    borrowed_.clear();
    hitSlots_.clear();
    misses_.shrink(0);
    hits_.shrink(0);
}

template <int Dim>
void UpdateBatch<Dim>::reserve(std::size_t bytes) {
    constexpr std::size_t kBlocksWithHits = 4;  // one of so many has hits, at most, usually
    constexpr std::size_t kBytesPerBlock =
        kCells + kCells / kBlocksWithHits + sizeof(BlockKey<Dim>) + sizeof(std::int32_t);
    const std::size_t blocks = bytes / kBytesPerBlock;
    clear();
    // What has been made and forgotten stays, and has been touched.
    keys_.resize(blocks);
    hitSlots_.resize(blocks);
    misses_.append(blocks * kCells);
    hits_.append(blocks / kBlocksWithHits * kCells);
    clear();
}

template <int Dim>
std::size_t UpdateBatch<Dim>::memoryBytes() const {
    return keys_.capacity() * sizeof(keys_[0]) + hitSlots_.capacity() * sizeof(hitSlots_[0]) +
           misses_.capacity() + hits_.capacity();
}

template class UpdateBatch<2>;
template class UpdateBatch<3>;

}  // namespace superray
