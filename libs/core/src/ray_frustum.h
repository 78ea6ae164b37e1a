#pragma once
// The cells that rays from one origin to one end cell can visit, slice by
// slice: a superset, exact in the same integers as the rays.

#include <superray/core/ray_line.h>

#include <algorithm>
#include <optional>

#include "saturation_snapshot.h"

namespace superray {

/// Slices [from, to) of a ray.
struct SliceRange {
    std::int32_t from = 0, to = 0;
    bool empty() const { return from >= to; }
};

template <int Dim>
class RayFrustum {
 public:
    /// Nothing if rays to that cell can have different dominant axes (cells on
    /// a diagonal, or next to the sensor's).
    static std::optional<RayFrustum> of(const Units<Dim>& origin, const Cell<Dim>& endCell) {
        RayFrustum f;
        Units<Dim> start, shortest, longest;
        for (int a = 0; a < Dim; ++a) {
            const std::int32_t startCell = RayLine<Dim>::cellOfUnits(origin[a]);
            f.flip_[a] = endCell[a] < startCell ? -1 : 0;
            start[a] = f.flip_[a] != 0 ? -origin[a] : origin[a];
            f.first_[a] = startCell ^ f.flip_[a];
            f.last_[a] = endCell[a] ^ f.flip_[a];
            // Where the cells are equal, rays may run either way, but stay.
            const bool stays = f.first_[a] == f.last_[a];
            const std::int64_t border = std::int64_t{f.last_[a]} << kUnitBits;
            shortest[a] = stays ? 0 : border + 1 - start[a];
            longest[a] = border + kUnitsPerCell - 1 - start[a];
            if (stays) longest[a] = std::max(longest[a], start[a] - border - 1);
            if (shortest[a] > shortest[f.dominant_]) f.dominant_ = a;
        }
        const int d = f.dominant_;
        for (int a = 0; a < Dim; ++a)
            if (a != d && longest[a] >= shortest[d]) return std::nullopt;
        if (shortest[d] == 0) return std::nullopt;

        const std::int64_t toBorder = ((std::int64_t{f.first_[d]} + 1) << kUnitBits) - start[d];
        for (int a = 0; a < Dim; ++a) {
            if (a == d || f.first_[a] == f.last_[a]) continue;
            f.lowSlope_[a] = RayLine<Dim>::slopeOf(shortest[a], longest[d]);
            f.highSlope_[a] = RayLine<Dim>::slopeOf(longest[a], shortest[d]);
            f.lowExit_[a] = start[a] + ((toBorder * f.lowSlope_[a]) >> kUnitBits);
            f.highExit_[a] = start[a] + ((toBorder * f.highSlope_[a]) >> kUnitBits);
        }
        return f;
    }

    std::int32_t slices() const { return last_[dominant_] - first_[dominant_] + 1; }

    /// The slices from the first to the last in which a cell of the frustum is
    /// not saturated. The end cell does not count: no ray of these misses it.
    SliceRange unsaturated(const SaturationSnapshot<Dim>& snapshot) const {
        SliceRange range{slices(), 0};
        for (std::int32_t k = 0; k < slices(); ++k) {
            if (saturated(k, snapshot)) continue;
            range.from = std::min(range.from, k);
            range.to = k + 1;
        }
        return range;
    }

    /// Mirrored bounds (inclusive) of the cells that rays visit in a slice.
    void bounds(std::int32_t k, Cell<Dim>& from, Cell<Dim>& to) const {
        for (int a = 0; a < Dim; ++a) {
            if (a == dominant_ || first_[a] == last_[a]) {
                from[a] = to[a] = a == dominant_ ? first_[a] + k : first_[a];
                continue;
            }
            // Lines of one start are ordered by slope: the steepest is ahead.
            from[a] = k == 0 ? first_[a]
                             : RayLine<Dim>::cellOfUnits(lowExit_[a] + (k - 1) * lowSlope_[a]);
            to[a] = k + 1 == slices()
                        ? last_[a]
                        : std::min(last_[a],
                                   RayLine<Dim>::cellOfUnits(highExit_[a] + k * highSlope_[a]));
        }
    }
    Cell<Dim> unmirrored(Cell<Dim> c) const {
        for (int a = 0; a < Dim; ++a) c[a] ^= flip_[a];
        return c;
    }

 private:
    bool saturated(std::int32_t k, const SaturationSnapshot<Dim>& snapshot) const {
        Cell<Dim> from, to;
        bounds(k, from, to);
        Cell<Dim> c = from;
        for (;;) {
            if (c != last_) {
                const Cell<Dim> cell = unmirrored(c);
                const BlockMask<Dim>* mask = snapshot.mask(blockOf<Dim>(cell));
                if (mask == nullptr || !mask->test(indexInBlock<Dim>(cell))) return false;
            }
            int a = 0;
            while (a < Dim && c[a] == to[a]) {
                c[a] = from[a];
                ++a;
            }
            if (a == Dim) return true;
            ++c[a];
        }
    }

    int dominant_ = 0;
    Cell<Dim> flip_{}, first_{}, last_{};
    Units<Dim> lowSlope_{}, highSlope_{}, lowExit_{}, highExit_{};
};

}  // namespace superray
