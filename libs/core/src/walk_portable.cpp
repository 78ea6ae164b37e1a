#include "walk_kernel.h"

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
            base = state.blockNumber(key) * static_cast<std::uint32_t>(kBlockCells<Dim>);
        }
        state.addresses.push(base + static_cast<std::uint32_t>(indexInBlock<Dim>(cell)));
    });
}

template void walkPortable(WalkState<2>&, const RayLine<2>&, std::int32_t, std::int32_t);
template void walkPortable(WalkState<3>&, const RayLine<3>&, std::int32_t, std::int32_t);

}  // namespace superray
