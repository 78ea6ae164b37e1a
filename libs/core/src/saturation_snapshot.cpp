#include "saturation_snapshot.h"

#include <cstring>

namespace superray {

template <int Dim>
BlockMask<Dim> cellsWithMisses(const std::uint8_t* misses, std::uint32_t threshold) {
    BlockMask<Dim> mask;
    if (threshold > 128) {
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (misses[i] >= threshold) mask.set(i);
        return mask;
    }
    // 8 counts at a time. Adding 128 - threshold to the low 7 bits carries into
    // the top bit where count >= threshold; the product gathers the top bits.
    constexpr std::uint64_t kOnes = 0x0101010101010101ull, kTops = kOnes << 7;
    const std::uint64_t toTop = (128 - threshold) * kOnes;
    for (int row = 0; row < kBlockCells<Dim> / 8; ++row) {
        std::uint64_t counts;
        std::memcpy(&counts, misses + 8 * row, 8);
        if (counts == 0) continue;
        const std::uint64_t tops = (((counts & ~kTops) + toTop) | counts) & kTops;
        const std::uint64_t bits = (tops >> 7) * 0x0102040810204080ull >> 56;
        mask.words[static_cast<std::size_t>(row >> 3)] |= bits << (8 * (row & 7));
    }
    return mask;
}

template <int Dim>
BlockMask<Dim>& SaturationSnapshot<Dim>::makeMask(const BlockKey<Dim>& key) {
    std::uint32_t number = directory_.number(key);
    if (number == 0) {
        masks_.emplace_back();
        number = static_cast<std::uint32_t>(masks_.size());
        directory_.setNumber(key, number);
    }
    return masks_[number - 1];
}

template <int Dim>
void SaturationSnapshot<Dim>::assign(const BlockBox<Dim>& box, const SaturationSource<Dim>* map,
                                     float lowerClamp) {
    directory_.reset(box);
    masks_.clear();
    if (map == nullptr) return;
    std::uint64_t volume = 1;
    for (int a = 0; a < Dim; ++a)
        volume *= static_cast<std::uint64_t>(box.hi[a] - box.lo[a] + 1);
    if (volume > kLargest) return;
    BlockKey<Dim> key = box.lo;
    for (;;) {
        if (const BlockMask<Dim>* mask = map->saturatedFree(key, lowerClamp))
            makeMask(key) = *mask;
        int a = 0;
        while (a < Dim && key[a] == box.hi[a]) {
            key[a] = box.lo[a];
            ++a;
        }
        if (a == Dim) return;
        ++key[a];
    }
}

template <int Dim>
void SaturationSnapshot<Dim>::add(const WalkState<Dim>& counted, std::uint32_t threshold) {
    for (std::size_t b = 0; b < counted.batch.blockCount(); ++b) {
        const BlockMask<Dim> missed = cellsWithMisses<Dim>(counted.batch.misses(b), threshold);
        if (!missed.any()) continue;
        BlockMask<Dim>& mask = makeMask(counted.batch.key(b));
        for (std::size_t w = 0; w < mask.words.size(); ++w) mask.words[w] |= missed.words[w];
    }
}

template BlockMask<2> cellsWithMisses<2>(const std::uint8_t*, std::uint32_t);
template BlockMask<3> cellsWithMisses<3>(const std::uint8_t*, std::uint32_t);
template class SaturationSnapshot<2>;
template class SaturationSnapshot<3>;

}  // namespace superray
