// SPDX-License-Identifier: BSD-3-Clause
#include "queries/nearest_occupied.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace superray {

template <int Dim>
NearestOccupied<Dim>::NearestOccupied(const OccupancyMap<Dim>& map, float occupied,
                                      double radius)
    : map_(map), occupied_(occupied), radius_(radius) {
    if (!(radius >= 0)) return;
    const double resolution = map.geometry().resolution();
    const int reach =
        static_cast<int>(std::min<double>(kMaxCells, std::ceil(radius / resolution)));
    Cell<Dim> c;
    c.fill(-reach);
    for (;;) {
        double squared = 0;
        for (int a = 0; a < Dim; ++a) {
            const double gap = std::max(0, std::abs(c[a]) - 1) * resolution;
            squared += gap * gap;
        }
        if (squared <= radius * radius) offsets_.push_back({c, std::sqrt(squared)});
        int a = 0;
        while (a < Dim && c[a] == reach) c[a++] = -reach;
        if (a == Dim) break;
        ++c[a];
    }
    const auto squaredNorm = [](const Cell<Dim>& o) {
        int sum = 0;
        for (int a = 0; a < Dim; ++a) sum += o[a] * o[a];
        return sum;
    };
    // Among equal bounds the centre cell and its neighbours come first.
    std::sort(offsets_.begin(), offsets_.end(), [&](const Offset& x, const Offset& y) {
        if (x.atLeast != y.atLeast) return x.atLeast < y.atLeast;
        return squaredNorm(x.cell) < squaredNorm(y.cell);
    });
}

template <int Dim>
std::optional<typename NearestOccupied<Dim>::Found> NearestOccupied<Dim>::operator()(
    const Point<Dim>& p) const {
    const auto& geometry = map_.geometry();
    const Cell<Dim> centre = geometry.cellOf(p);
    std::optional<Found> best;
    for (const Offset& offset : offsets_) {
        if (best && offset.atLeast >= best->distance) break;
        Cell<Dim> c;
        bool addressable = true;
        double squared = 0;
        for (int a = 0; a < Dim; ++a) {
            c[a] = centre[a] + offset.cell[a];
            addressable = addressable && c[a] >= -kCellLimit && c[a] < kCellLimit;
            const double low = c[a] * geometry.resolution();
            const double gap = std::max({0.0, low - p[a], p[a] - low - geometry.resolution()});
            squared += gap * gap;
        }
        // The cell of the point itself has distance 0, whatever rounding says.
        const double distance = c == centre ? 0 : std::sqrt(squared);
        if (!addressable || distance > radius_ || (best && distance >= best->distance))
            continue;
        const auto value = map_.logOdds(c);
        if (value && *value >= occupied_) best = Found{c, distance};
    }
    return best;
}

template class NearestOccupied<2>;
template class NearestOccupied<3>;

}  // namespace superray
