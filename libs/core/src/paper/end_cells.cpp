// SPDX-License-Identifier: BSD-3-Clause
#include "paper/end_cells.h"

namespace superray {

template <int Dim>
void EndCells<Dim>::assign(const RayBundle<Dim>& rays, std::size_t begin, std::size_t end,
                           const BlockBox<Dim>& box) {
    first_ = begin;
    directory_.reset(box);
    keys_.clear();
    hits_.clear();
    addresses_.resize(end - begin);

    BlockKey<Dim> current{};
    std::uint32_t base = 0;
    bool known = false;  // consecutive points often share a block
    for (std::size_t i = begin; i < end; ++i) {
        const Cell<Dim> cell = rays.geometry().cellOf(rays.end(i));
        const BlockKey<Dim> key = blockOf<Dim>(cell);
        if (!known || key != current) {
            std::uint32_t id = directory_.id(key);
            if (id == 0) {
                keys_.push_back(key);
                id = static_cast<std::uint32_t>(keys_.size());
                directory_.setId(key, id);
                hits_.resize(hits_.size() + kCells, 0);
            }
            base = (id - 1) * kCells;
            current = key;
            known = true;
        }
        const std::uint32_t address =
            base + static_cast<std::uint32_t>(indexInBlock<Dim>(cell));
        addresses_[i - begin] = address;
        hits_[address] =
            ScanCounts<Dim>::saturatingAdd(hits_[address], rays.kind(i) == RayEnd::hit ? 1 : 0);
    }
    enclosed_.assign(keys_.size(), {});
}

template <int Dim>
void EndCells<Dim>::findEnclosed(const CullingRegion<Dim>& region) {
    for (std::size_t b = 0; b < keys_.size(); ++b) {
        const BlockMask<Dim>* mask = region.enclosed(keys_[b]);
        enclosed_[b] = mask != nullptr ? *mask : BlockMask<Dim>{};
    }
}

template <int Dim>
void EndCells<Dim>::addHits(ScanCounts<Dim>& counts) const {
    for (std::size_t b = 0; b < keys_.size(); ++b) {
        const std::uint8_t* hits = hits_.data() + b * kCells;
        std::uint8_t* sum = counts.batch.hitsOf(counts.batchBlock(keys_[b]));
        for (std::uint32_t i = 0; i < kCells; ++i)
            sum[i] = ScanCounts<Dim>::saturatingAdd(sum[i], hits[i]);
    }
}

template class EndCells<2>;
template class EndCells<3>;

}  // namespace superray
