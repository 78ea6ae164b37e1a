// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file traversal.h
/// The 6-connected (2D: 4-connected) walk along a ray: pure functions.

#include <superray/core/ray_line.h>

namespace superray {

/// Calls visit(cell) for the cells of the ray before its end cell (the free
/// cells, design rule 3) that lie in the slices [from, to), sensor to end.
///
/// Works slice by slice: inside one, each axis steps at most once (in the last
/// one up to twice, where rounding was made up for), so the order of steps
/// needs a comparison only where two axes step in the same slice.
template <int Dim, typename Visit>
void forEachFreeCell(const RayLine<Dim>& line, std::int32_t from, std::int32_t to,
                     Visit&& visit) {
    const std::int32_t slices = line.slices();
    for (std::int32_t k = from; k < to; ++k) {
        Cell<Dim> cell, exit;
        int steps = 0;
        for (int a = 0; a < Dim; ++a) {
            cell[a] = line.entryCell(a, k);
            exit[a] = line.exitCell(a, k);
            steps += exit[a] - cell[a];
        }
        const bool lastSlice = k + 1 == slices;
        for (; steps > 0; --steps) {
            visit(line.unmirrored(cell));
            int next = -1;
            for (int a = 0; a < Dim; ++a) {
                if (a == line.major || cell[a] == exit[a]) continue;
                if (next < 0 || line.crossesBefore(a, cell[a], next, cell[next])) next = a;
            }
            ++cell[next];
        }
        if (!lastSlice) visit(line.unmirrored(cell));
    }
}

template <int Dim, typename Visit>
void forEachFreeCell(const RayLine<Dim>& line, Visit&& visit) {
    forEachFreeCell(line, 0, line.slices(), visit);
}

}  // namespace superray
