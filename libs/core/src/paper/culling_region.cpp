// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/culling_region.h>

#include "counting/block_directory.h"

namespace superray {
namespace {

using Row = std::uint32_t;  // 8 bits: the cells of a row along x
constexpr Row kFullRow = 0xFF;

/// Ones of `row` reachable from its low end: trailing ones.
Row upwardRun(Row row) {
    return (row ^ (row + 1)) >> 1 & kFullRow;
}
/// Ones of `row` reachable from its high end: leading ones.
Row downwardRun(Row row) {
    const Row holes = ~row & kFullRow;
    if (holes == 0) return kFullRow;
    const int highest = 31 - __builtin_clz(holes);
    return kFullRow & ~((Row{2} << highest) - 1);
}

template <int Dim>
Row rowOf(const BlockMask<Dim>& m, int row) {
    return static_cast<Row>(m.words[row >> 3] >> ((row & 7) * 8)) & kFullRow;
}
template <int Dim>
void setRow(BlockMask<Dim>& m, int row, Row bits) {
    m.words[row >> 3] |= std::uint64_t{bits} << ((row & 7) * 8);
}

}  // namespace

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
    const BlockKey<Dim> home = blockOf<Dim>(sensor);
    impl.enqueue(home);

    constexpr int kRows = kBlockCells<Dim> / kBlockEdge;
    constexpr BlockMask<Dim> kNone{};
    for (std::size_t next = 0; next < impl.queue.size(); ++next) {
        const BlockKey<Dim> key = impl.queue[next];
        const BlockMask<Dim>* saturated = saturation(key);
        if (saturated == nullptr) saturated = &kNone;

        // Per axis: +1 if the block lies above the sensor's block, -1 below,
        // 0 beside it; then rows on both sides of the sensor's own occur.
        std::array<int, 3> side{};
        std::array<const BlockMask<Dim>*, 3> inward{};
        for (int a = 0; a < Dim; ++a) {
            side[a] = (key[a] > home[a]) - (key[a] < home[a]);
            if (side[a] == 0) continue;
            BlockKey<Dim> nearer = key;
            nearer[a] -= side[a];
            const BlockMask<Dim>* m = impl.mask(nearer);
            inward[a] = m != nullptr ? m : &kNone;
        }
        std::array<int, 3> at{};  // the sensor inside its block
        for (int a = 0; a < Dim; ++a) at[a] = sensor[a] & (kBlockEdge - 1);

        BlockMask<Dim> region, enclosed;
        // Rows in an order in which each comes after its inward neighbours:
        // distance 0 .. 7 from the inward end, or outwards from the sensor.
        const auto coordinate = [&](int axis, int i) {
            if (side[axis] > 0) return i;
            if (side[axis] < 0) return kBlockEdge - 1 - i;
            // at, at+1, .., 7, at-1, .., 0
            return i < kBlockEdge - at[axis] ? at[axis] + i : kBlockEdge - 1 - i;
        };
        for (int r = 0; r < kRows; ++r) {
            std::array<int, 3> c{};  // c[1] = y, c[2] = z
            c[1] = coordinate(1, r & (kBlockEdge - 1));
            if (Dim == 3) c[2] = coordinate(2, r >> kBlockBits);
            const int row = c[1] + (Dim == 3 ? kBlockEdge * c[2] : 0);
            // Cells whose nearer neighbours along y and z are in the region ...
            Row inside = kFullRow;
            for (int a = 1; a < Dim; ++a) {
                const int pitch = a == 1 ? 1 : kBlockEdge;
                const int step = side[a] != 0 ? side[a] : (c[a] > at[a]) - (c[a] < at[a]);
                if (step == 0) continue;
                const int inner = c[a] - step;
                if (inner >= 0 && inner < kBlockEdge)
                    inside &= rowOf<Dim>(region, row - step * pitch);
                else  // the facing row of the inward block
                    inside &= rowOf<Dim>(*inward[a], row + step * (kBlockEdge - 1) * pitch);
            }
            if (inside == 0) continue;
            // ... and along x: the region is the run of saturated ones from the
            // sensor's side; a cell is enclosed if its nearer neighbour is in it.
            Row run = inside & rowOf<Dim>(*saturated, row);
            if (side[0] > 0) {
                const Row carry = rowOf<Dim>(*inward[0], row) >> 7;
                run = carry != 0 ? upwardRun(run) : 0;
                inside &= run << 1 | carry;
            } else if (side[0] < 0) {
                const Row carry = rowOf<Dim>(*inward[0], row) & 1;
                run = carry != 0 ? downwardRun(run) : 0;
                inside &= run >> 1 | carry << 7;
            } else {
                const Row own = Row{1} << at[0], below = own - 1;
                const Row above = kFullRow & ~(own | below);
                run = (run & own) == 0 ? 0
                                       : (upwardRun(run | below) & ~below) |
                                             (downwardRun(run | above | own) & below);
                inside &= own | (run << 1 & above) | (run >> 1 & below);
            }
            setRow<Dim>(region, row, run);
            setRow<Dim>(enclosed, row, inside);
        }
        impl.enclosed[next] = enclosed;
        if (!region.any()) continue;
        cells_ += static_cast<std::uint64_t>(region.count());
        impl.masks[next] = region;
        for (int a = 0; a < Dim; ++a) {
            for (int direction : {-1, 1}) {
                if (side[a] != 0 && direction != side[a]) continue;
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
