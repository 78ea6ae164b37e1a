#include "walk_kernel.h"

#include <cstring>
#include <functional>

#define SUPERRAY_TARGET
#include "find_directions.inc"
//
#include "find_ends.inc"

namespace superray {

template <int Dim>
void walkPortable(WalkState<Dim>& state, const RayLine<Dim>& line, std::int32_t from,
                  std::int32_t to) {
    BlockKey<Dim> current{};
    std::uint32_t base = 0;
    bool known = false;
    forEachFreeCell(line, from, to, [&](const Cell<Dim>& cell) {
        const BlockKey<Dim> key = blockOf<Dim>(cell);
        if (!known || key != current) {
            current = key;
            known = true;
            base = state.offsetOf(key);
        }
        state.addresses.push(base + static_cast<std::uint32_t>(indexInBlock<Dim>(cell)));
    });
}

namespace {

/// Whether more misses matter to a cell; tells how many do. A superset of the
/// rays' cells may leave the scan's blocks: those outside do not matter.
template <int Dim>
bool matters(WalkState<Dim>& state, const Cell<Dim>& cell, Look& look) {
    const BlockKey<Dim> key = blockOf<Dim>(cell);
    if (!state.directory.box().contains(key)) return false;
    const std::uint32_t number = state.numberOf(key);
    look.needed =
        number & WalkState<Dim>::kMayExceedUnknown ? state.enough : state.enoughUnknown;
    look.cell = WalkState<Dim>::offset(number) +
                static_cast<std::uint32_t>(indexInBlock<Dim>(cell));
    return state.batch.missArena()[look.cell] < look.needed;
}

template <int Dim>
void walkLine(WalkState<Dim>& state, const RayLine<Dim>& line, std::int32_t from) {
    walkPortable(state, line, from, line.slices());
}

template <int Dim>
void walkRays(WalkState<Dim>& state, const RayBundle<Dim>& rays, const RayLanes& lanes,
              std::int32_t from) {
    for (int i = 0; i < lanes.count; ++i) {
        const RayLine<Dim> line(rays.geometry(), rays.commonOrigin(), rays.end(lanes.ray[i]));
        state.addresses.reserveMore(static_cast<std::size_t>(line.steps()));
        walkPortable(state, line, from, line.slices());
    }
}

template <int Dim>
void boundGroups(const RayDirections<Dim>& d, std::size_t first, GroupBounds<Dim>& out) {
    for (std::size_t g = 0; g < GroupBounds<Dim>::kGroups; ++g) {
        for (std::size_t r = 0; r < kGroupRays; ++r) {
            const std::size_t ray = first + g * kGroupRays + r;
            const auto join = [&](auto& bound, auto value, const auto& better) {
                if (r == 0 || better(value, bound)) bound = value;
            };
            join(out.length[g], d.length[ray], std::greater<>());
            join(out.lowestKind[g], d.kind[ray], std::less<>());
            join(out.highestKind[g], d.kind[ray], std::greater<>());
            for (int m = 0; m < Dim - 1; ++m) {
                join(out.low[m][g], d.slope[m][ray], std::less<>());
                join(out.high[m][g], d.slope[m][ray], std::greater<>());
                join(out.reach[m][g], d.slope[m][ray] * d.length[ray], std::greater<>());
            }
        }
    }
}

template <int Dim>
Look firstUnsaturated(WalkState<Dim>& state, const Beam<Dim>& beam, std::int32_t from,
                      std::int32_t to) {
    Look look;
    for (std::int32_t k = from; k < to; ++k) {
        look.slice = k;
        Cell<Dim> low, high;
        for (int a = 0; a < Dim; ++a) {
            low[a] = a == beam.common.dominant ? beam.common.first[a] + k : beam.low(a, k);
            high[a] = a == beam.common.dominant ? low[a] : beam.high(a, k);
        }
        Cell<Dim> c = low;
        for (int a = 0; a < Dim;) {
            Cell<Dim> cell = c;
            for (int b = 0; b < Dim; ++b) cell[b] ^= beam.common.flip[b];
            if (matters(state, cell, look)) return look;
            for (a = 0; a < Dim && c[a] == high[a]; ++a) c[a] = low[a];
            if (a < Dim) ++c[a];
        }
    }
    look.slice = to;
    return look;
}

}  // namespace

template <int Dim>
WalkKernels<Dim> portableKernels() {
    return {walkLine<Dim>, walkRays<Dim>, findDirections<Dim>, findEnds<Dim>, boundGroups<Dim>,
            firstUnsaturated<Dim>};
}

template void walkPortable(WalkState<2>&, const RayLine<2>&, std::int32_t, std::int32_t);
template void walkPortable(WalkState<3>&, const RayLine<3>&, std::int32_t, std::int32_t);
template WalkKernels<2> portableKernels();
template WalkKernels<3> portableKernels();

}  // namespace superray
