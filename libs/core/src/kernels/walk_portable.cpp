// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/traversal.h>

#include "kernels/walk_kernel.h"

namespace superray {

template <int Dim>
void walkPortable(ScanCounts<Dim>& counts, const RayLine<Dim>& line, std::int32_t from,
                  std::int32_t to) {
    BlockKey<Dim> current{};
    std::uint32_t base = 0;
    bool known = false;
    forEachFreeCell(line, from, to, [&](const Cell<Dim>& cell) {
        const BlockKey<Dim> key = blockOf<Dim>(cell);
        if (!known || key != current) {
            current = key;
            known = true;
            base = counts.offsetOf(key);
        }
        counts.addresses.push(base + static_cast<std::uint32_t>(indexInBlock<Dim>(cell)));
    });
}

template <int Dim>
void walkPortable(ScanCounts<Dim>& counts, const RayBundle<Dim>& rays, std::size_t ray,
                  std::int32_t from) {
    const RayLine<Dim> line(rays.geometry(), rays.commonOrigin(), rays.end(ray));
    counts.addresses.reserveMore(static_cast<std::size_t>(line.steps()));
    walkPortable(counts, line, from, line.slices());
}

template void walkPortable(ScanCounts<2>&, const RayLine<2>&, std::int32_t, std::int32_t);
template void walkPortable(ScanCounts<3>&, const RayLine<3>&, std::int32_t, std::int32_t);
template void walkPortable(ScanCounts<2>&, const RayBundle<2>&, std::size_t, std::int32_t);
template void walkPortable(ScanCounts<3>&, const RayBundle<3>&, std::size_t, std::int32_t);

}  // namespace superray
