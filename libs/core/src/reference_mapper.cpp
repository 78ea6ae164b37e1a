// SPDX-License-Identifier: BSD-3-Clause
// The oracle. Slow and obvious on purpose: it shares with the fast paths only
// the definition of the digital line (RayLine) and of one cell's update
// (SensorModel::updated).

#include <superray/core/ray_line.h>
#include <superray/core/reference_mapper.h>

namespace superray {
namespace {

/// The axis whose next border the ray crosses first; -1 at the end cell.
/// Times are compared as exact fractions: t = (border - exit0) / slope.
template <int Dim>
int nextAxis(const RayLine<Dim>& line, const Cell<Dim>& cell) {
    __extension__ using Wide = __int128;
    // Order of precedence in ties: higher axes first, the major one last.
    int best = -1;
    Wide bestDistance = 0, bestSlope = 1;
    const auto consider = [&](int a) {
        if (cell[a] == line.last[a]) return;
        const Wide distance = Wide{(std::int64_t{cell[a]} + 1) * kUnitsPerCell} - line.exit0[a];
        const Wide slope = line.slope[a];
        if (best < 0 || distance * bestSlope < bestDistance * slope) {
            best = a;
            bestDistance = distance;
            bestSlope = slope;
        }
    };
    for (int a = Dim - 1; a >= 0; --a)
        if (a != line.major) consider(a);
    consider(line.major);
    return best;
}

}  // namespace

template <int Dim>
CellCountMap<Dim> countCells(const RayBundle<Dim>& rays) {
    CellCountMap<Dim> counts;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const RayLine<Dim> line(rays.geometry(), rays.origin(i), rays.end(i));
        Cell<Dim> cell = line.first;
        for (int axis = nextAxis(line, cell); axis >= 0; axis = nextAxis(line, cell)) {
            ++counts[line.unmirrored(cell)].misses;
            ++cell[axis];
        }
        if (rays.kind(i) == RayEnd::hit) ++counts[line.unmirrored(cell)].hits;
    }
    return counts;
}

template <int Dim>
void ReferenceMapper<Dim>::insert(const RayBundle<Dim>& rays) {
    for (const auto& [cell, count] : countCells(rays)) {
        float& value = cells_.emplace(cell, 0.0f).first->second;
        value = model_.updated(value, count.misses, count.hits, policy_);
    }
}

template CellCountMap<2> countCells(const RayBundle<2>&);
template CellCountMap<3> countCells(const RayBundle<3>&);
template class ReferenceMapper<2>;
template class ReferenceMapper<3>;

}  // namespace superray
