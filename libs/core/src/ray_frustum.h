#pragma once
// The cells that rays from one origin to one end cell can visit, slice by
// slice: a superset, exact in the same integers as the rays.

#include <superray/core/ray_line.h>

#include <algorithm>

#include "walk_kernel.h"

namespace superray {

/// Slices [from, to) of a ray.
struct SliceRange {
    std::int32_t from = 0, to = 0;
    bool empty() const { return from >= to; }
};

/// Bounds of lines with one origin and one end cell. Lines of one dominant
/// axis are ordered by their slopes: of two, the steeper is nowhere behind.
template <int Dim>
class RayFrustum {
 public:
    explicit RayFrustum(const RayLine<Dim>& line) : low_(line), high_(line) {}

    /// Makes room for a line. False, and no change, if it has another dominant
    /// axis or direction (end cells on a diagonal, or next to the sensor's).
    bool include(const RayLine<Dim>& line) {
        if (line.dominant != low_.dominant || line.flip != low_.flip) return false;
        for (int a = 0; a < Dim; ++a) {
            low_.slope[a] = std::min(low_.slope[a], line.slope[a]);
            low_.exit0[a] = std::min(low_.exit0[a], line.exit0[a]);
            high_.slope[a] = std::max(high_.slope[a], line.slope[a]);
            high_.exit0[a] = std::max(high_.exit0[a], line.exit0[a]);
        }
        return true;
    }

    std::int32_t slices() const { return low_.slices(); }

    /// Of the slices in `range`, from the first to the last that has a cell of
    /// the frustum with fewer than `enough` misses counted in `state`. The end
    /// cell does not matter: no ray of these misses it.
    SliceRange unsaturated(WalkState<Dim>& state, std::uint32_t enough,
                           SliceRange range) const {
        while (!range.empty() && saturated(range.from, state, enough)) ++range.from;
        while (!range.empty() && saturated(range.to - 1, state, enough)) --range.to;
        return range;
    }

 private:
    bool saturated(std::int32_t k, WalkState<Dim>& state, std::uint32_t enough) const {
        Cell<Dim> from, to;
        for (int a = 0; a < Dim; ++a) {
            from[a] = low_.entryCell(a, k);
            to[a] = high_.exitCell(a, k);
        }
        Cell<Dim> c = from;
        for (;;) {
            if (c != low_.last && state.misses(low_.unmirrored(c)) < enough) return false;
            int a = 0;
            while (a < Dim && c[a] == to[a]) {
                c[a] = from[a];
                ++a;
            }
            if (a == Dim) return true;
            ++c[a];
        }
    }

    RayLine<Dim> low_, high_;  // only slope and exit0 differ
};

}  // namespace superray
