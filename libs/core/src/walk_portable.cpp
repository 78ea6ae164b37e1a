#include "walk_kernel.h"

#include <cstring>

#define SUPERRAY_TARGET
#include "find_directions.inc"

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

/// Whether more misses matter to a cell. A superset of the rays' cells may leave
/// the scan's blocks: those outside do not matter.
template <int Dim>
bool matters(WalkState<Dim>& state, const Cell<Dim>& cell) {
    const BlockKey<Dim> key = blockOf<Dim>(cell);
    if (!state.directory.box().contains(key)) return false;
    const std::uint32_t number = state.numberOf(key);
    const std::uint32_t needed =
        number & WalkState<Dim>::kMayExceedUnknown ? state.enough : state.enoughUnknown;
    const auto index = static_cast<std::uint32_t>(indexInBlock<Dim>(cell));
    return state.batch.missArena()[WalkState<Dim>::offset(number) + index] < needed;
}

template <int Dim>
void walkLanes(WalkState<Dim>& state, const RayBundle<Dim>& rays, const RayLanes& lanes,
               std::int32_t from) {
    for (int i = 0; i < lanes.count; ++i) {
        const RayLine<Dim> line(rays.geometry(), rays.commonOrigin(), rays.end(lanes.ray[i]));
        walkPortable(state, line, from, line.slices());
    }
}

template <int Dim>
std::int32_t firstUnsaturated(WalkState<Dim>& state, const Beam<Dim>& beam, std::int32_t from,
                              std::int32_t to) {
    for (std::int32_t k = from; k < to; ++k) {
        Cell<Dim> low, high;
        for (int a = 0; a < Dim; ++a) {
            low[a] = a == beam.dominant ? beam.first[a] + k : beam.low(a, k);
            high[a] = a == beam.dominant ? low[a] : beam.high(a, k);
        }
        Cell<Dim> c = low;
        for (int a = 0; a < Dim;) {
            Cell<Dim> cell = c;
            for (int b = 0; b < Dim; ++b) cell[b] ^= beam.flip[b];
            if (matters(state, cell)) return k;
            for (a = 0; a < Dim && c[a] == high[a]; ++a) c[a] = low[a];
            if (a < Dim) ++c[a];
        }
    }
    return to;
}

}  // namespace

template <int Dim>
WalkKernels<Dim> portableKernels() {
    return {walkPortable<Dim>, walkLanes<Dim>, findDirections<Dim>, firstUnsaturated<Dim>};
}

template void walkPortable(WalkState<2>&, const RayLine<2>&, std::int32_t, std::int32_t);
template void walkPortable(WalkState<3>&, const RayLine<3>&, std::int32_t, std::int32_t);
template WalkKernels<2> portableKernels();
template WalkKernels<3> portableKernels();

}  // namespace superray
