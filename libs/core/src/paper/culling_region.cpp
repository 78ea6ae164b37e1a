// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/culling_region.h>

#include "counting/block_directory.h"
#include "paper/culling_block.h"

namespace superray {

template <int Dim>
struct CullingRegion<Dim>::Impl {
    BlockDirectory<Dim> directory;         // block -> 1 + index into masks
    std::vector<BlockMask<Dim>> masks;     // the region
    std::vector<BlockMask<Dim>> enclosed;  // cells with all nearer neighbours in it
    std::vector<BlockKey<Dim>> queue;      // parallel to both, nearest first

    const BlockMask<Dim>* mask(const BlockKey<Dim>& key) const {
        const std::uint32_t n = directory.id(key);
        return n == 0 ? nullptr : &masks[n - 1];
    }
    /// Does nothing for a block that is out of bounds, or queued already.
    void enqueue(const BlockKey<Dim>& key) {
        if (!directory.box().contains(key) || directory.id(key) != 0) return;
        queue.push_back(key);
        masks.emplace_back();
        enclosed.emplace_back();
        directory.setId(key, static_cast<std::uint32_t>(masks.size()));
    }
};

template <int Dim>
CullingRegion<Dim>::CullingRegion() : impl_(std::make_unique<Impl>()) {}
template <int Dim>
CullingRegion<Dim>::~CullingRegion() = default;
template <int Dim>
CullingRegion<Dim>::CullingRegion(CullingRegion&&) noexcept = default;
template <int Dim>
CullingRegion<Dim>& CullingRegion<Dim>::operator=(CullingRegion&&) noexcept = default;

template <int Dim>
void CullingRegion<Dim>::clear() {
    cells_ = 0;
    impl_->masks.clear();
    impl_->enclosed.clear();
    impl_->queue.clear();
}

template <int Dim>
void CullingRegion<Dim>::build(const Cell<Dim>& sensor, const Cell<Dim>& lowest,
                               const Cell<Dim>& highest, const Saturation& saturation) {
    Impl& impl = *impl_;
    clear();
    sensor_ = sensor;
    impl.directory.reset({blockOf<Dim>(lowest), blockOf<Dim>(highest)});
    impl.enqueue(blockOf<Dim>(sensor));
    const auto maskOf = [&](const BlockKey<Dim>& key) { return impl.mask(key); };
    for (std::size_t next = 0; next < impl.queue.size(); ++next) {
        const BlockKey<Dim> key = impl.queue[next];
        const CullingBlock<Dim> block(key, sensor, maskOf);
        const BlockMask<Dim>* saturated = saturation(key);
        const auto filled = block.fill(saturated != nullptr ? *saturated : BlockMask<Dim>{});
        impl.enclosed[next] = filled.enclosed;
        if (!filled.region.any()) continue;
        cells_ += static_cast<std::uint64_t>(filled.region.count());
        impl.masks[next] = filled.region;
        // Outwards: away from the sensor, and to both sides where it is beside the block.
        for (int a = 0; a < Dim; ++a) {
            for (int direction : {-1, 1}) {
                if (block.side(a) != 0 && direction != block.side(a)) continue;
                BlockKey<Dim> outer = key;
                outer[a] += direction;
                impl.enqueue(outer);
            }
        }
    }
}

template <int Dim>
bool CullingRegion<Dim>::contains(const Cell<Dim>& cell) const {
    if (cells_ == 0) return false;
    const BlockKey<Dim> key = blockOf<Dim>(cell);
    if (!impl_->directory.box().contains(key)) return false;
    const BlockMask<Dim>* mask = impl_->mask(key);
    return mask != nullptr && mask->test(indexInBlock<Dim>(cell));
}

template <int Dim>
const BlockMask<Dim>* CullingRegion<Dim>::enclosed(const BlockKey<Dim>& key) const {
    if (cells_ == 0 || !impl_->directory.box().contains(key)) return nullptr;
    const std::uint32_t n = impl_->directory.id(key);
    return n == 0 ? nullptr : &impl_->enclosed[n - 1];
}

template <int Dim>
std::int32_t CullingRegion<Dim>::firstSliceToWalk(const RayLine<Dim>& line,
                                                  std::int32_t hint) const {
    const auto inside = [&](std::int32_t slice) {
        Cell<Dim> c;
        for (int a = 0; a < Dim; ++a) c[a] = line.entryCell(a, slice);
        c = line.unmirrored(c);
        const BlockMask<Dim>* mask = impl_->mask(blockOf<Dim>(c));
        return mask != nullptr && mask->test(indexInBlock<Dim>(c));
    };
    if (cells_ == 0 || !inside(0)) return 0;
    // Being inside is monotone along the ray: gallop from the hint, then bisect
    // to the last slice entered inside.
    const std::int32_t last = line.slices() - 1;
    std::int32_t lo = 0, hi = last + 1;  // inside(lo), !inside(hi)
    std::int32_t probe = std::clamp(hint, std::int32_t{0}, last);
    for (std::int32_t stride = 2; lo < probe && probe < hi; stride *= 2) {
        if (inside(probe)) {
            lo = probe;
            probe += std::min(stride, last + 1 - probe);
        } else {
            hi = probe;
            probe -= std::min(stride, probe);
        }
    }
    while (hi - lo > 1) {
        const std::int32_t middle = lo + (hi - lo) / 2;
        (inside(middle) ? lo : hi) = middle;
    }
    return lo;
}

template class CullingRegion<2>;
template class CullingRegion<3>;

}  // namespace superray
