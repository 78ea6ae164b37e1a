// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The last slices of rays of one sector: one ray per lane, a slice of each at a
// time. Where few slices are left, this takes less than going from ray to ray,
// which 8 slices at once repay.

#include "counting/scan_counts.h"
#include "kernels/generic/line_lanes.h"

#include <cstring>

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

/// Makes the missing blocks of lanes, by their cells.
template <int Dim>
Ints madeIds(ScanCounts<Dim>& counts, const Ints (&cells)[Dim], Ints ids, int missing) {
    for (; missing != 0; missing &= missing - 1) {
        const int lane = __builtin_ctz(static_cast<unsigned>(missing));
        BlockKey<Dim> key;
        for (int a = 0; a < Dim; ++a) key[a] = cells[a][lane] >> kBlockBits;
        ids[lane] = static_cast<std::int32_t>(counts.idOf(key));
    }
    return ids;
}

template <typename Simd, int Dim, int D>
class EndsWalk {
    static constexpr int kMinors = Dim - 1;
    static constexpr int kOther = kMinors - 1;
    using Long8 = typename Simd::Long8;

 public:
    SUPERRAY_INLINE EndsWalk(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays,
                             const RayLanes& lanes)
        : counts_(counts), lines_(setUp<Simd, Dim, D>(rays, lanes)) {
        std::memcpy(&slice_, lanes.from, sizeof slice_);
        valid_ = Simd::bitsOf(slice_ <= lines_.lastSlice) & ((1 << lanes.count) - 1);
        for (int alone = valid_ & lines_.twice; alone != 0; alone &= alone - 1) {
            const int lane = __builtin_ctz(static_cast<unsigned>(alone));
            walkPortable(counts, rays, lanes.ray[lane], lanes.from[lane]);
        }
        valid_ &= ~lines_.twice;
        const BlockDirectory<Dim>& directory = counts.directory;
        for (int a = 0; a < Dim; ++a) {
            strides_[a] = static_cast<std::int32_t>(directory.stride(a));
            lowest_ += directory.box().lo[a] * strides_[a];
        }
        major_ = lines_.first[D] + slice_;
        for (int m = 0; m < kMinors; ++m) {
            // exit = exit0 + slice * slope; a slice is entered where the one before
            // is left
            exits_[m] = lines_.exit0[m] + Simd::product(Simd::wide(slice_), lines_.slope[m]);
            entry_[m] = Simd::cells(exits_[m] - lines_.slope[m]);
        }
    }

    /// Goes on until all lanes are at their ends.
    SUPERRAY_INLINE void run() {
        for (; valid_ != 0; slice_ += 1, major_ += 1) {
            counts_.addresses.reserveMore(8 * Dim);
            walkSlices();
        }
    }

 private:
    /// One slice of each valid lane; cells A, B and C as in LineWalk.
    SUPERRAY_INLINE void walkSlices() {
        std::uint32_t* out = counts_.addresses.end();
        const int atEnd = Simd::bitsOf(slice_ == lines_.lastSlice) & valid_;
        Ints exit[kMinors];
        int step[kMinors], anyStep = 0;
        for (int m = 0; m < kMinors; ++m) {
            exit[m] = Simd::select(Simd::maskOf(atEnd), lines_.last[minorAxis<D>(m)],
                                   Simd::cells(exits_[m]));
            step[m] = Simd::differing(entry_[m], exit[m]) & valid_;
            anyStep |= step[m];
        }
        const int entered = valid_ & (anyStep | ~atEnd), left = anyStep & ~atEnd;
        out = Simd::compress(out, addresses(entry_[0], entry_[kOther], entered), entered);
        if (left != 0) out = Simd::compress(out, addresses(exit[0], exit[kOther], left), left);
        if constexpr (kMinors == 2) {
            if (const int both = step[0] & step[1]; both != 0) {
                const typename Simd::Mask first =
                    Simd::firstCrosses(exits_[0] - lines_.slope[0], lines_.slope[0],
                                       exits_[1] - lines_.slope[1], lines_.slope[1]);
                out = Simd::compress(out,
                                     addresses(Simd::select(first, exit[0], entry_[0]),
                                               Simd::select(first, entry_[1], exit[1]), both),
                                     both);
            }
        }
        counts_.addresses.setEnd(out);
        for (int m = 0; m < kMinors; ++m) {
            entry_[m] = exit[m];
            exits_[m] = exits_[m] + lines_.slope[m];
        }
        valid_ &= ~atEnd;
    }

    /// Addresses of the cells of the lanes in the mask; of the others, any:
    /// cell = mirrored ^ flip; index = sum of (cell >> 3) * stride - lowest;
    /// address = (id[index] - 1) * cells per block + index of the cell in its
    /// block
    SUPERRAY_INLINE UInts addresses(Ints minor0, Ints minor1, int mask) {
        Ints cells[Dim];
        Ints index = Ints{} - lowest_, local{};
        for (int a = 0; a < Dim; ++a) {
            const Ints& c = a == D ? major_ : a == minorAxis<D>(0) ? minor0 : minor1;
            cells[a] = c ^ lines_.flip[a];
            index += (cells[a] >> kBlockBits) * strides_[a];
            local |= (cells[a] & (kBlockEdge - 1)) << (kBlockBits * a);
        }
        // Index 0 exists.
        index = Simd::select(Simd::maskOf(mask), index, Ints{});
        const auto* const ids = reinterpret_cast<const std::int32_t*>(counts_.directory.data());
        Ints id = Simd::gatherInts(ids, index);
        const int missing = Simd::bitsOf(id == 0) & mask;
        if (__builtin_expect(missing != 0, 0)) id = madeIds<Dim>(counts_, cells, id, missing);
        return (UInts)(((id - 1) << (kBlockBits * Dim)) | local);
    }

    ScanCounts<Dim>& counts_;
    const LineLanes<Simd, Dim> lines_;
    Ints slice_, major_;  ///< where each lane is: slice, and mirrored major cell
    Ints entry_[kMinors];
    Long8 exits_[kMinors];
    int valid_;  ///< bits of the lanes that go on
    std::int32_t strides_[Dim], lowest_ = 0;
};

/// As WalkRays. \pre all from > 0
template <typename Simd, int Dim>
void walkEnds(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays, const RayLanes& lanes) {
    switch (lanes.sector & 3) {
        case 0:
            return EndsWalk<Simd, Dim, 0>(counts, rays, lanes).run();
        case 1:
            return EndsWalk<Simd, Dim, 1>(counts, rays, lanes).run();
        default:
            return EndsWalk<Simd, Dim, Dim - 1>(counts, rays, lanes).run();
    }
}

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
