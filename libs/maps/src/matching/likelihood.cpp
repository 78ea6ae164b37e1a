// SPDX-License-Identifier: BSD-3-Clause
#include "matching/likelihood.h"

#include <cmath>
#include <vector>

#include "queries/distance_to_cell.h"

namespace superray {
namespace {

/// Log of the mixture, by squared distance; 0 for a hit.
class PointScore {
 public:
    explicit PointScore(const TLikelihoodOptions& o)
        : perSquaredMetre_(-0.5 / (o.sigma * o.sigma)), uniform_(o.uniformWeight) {}

    double operator()(double squaredMetres) const {
        const double gaussian = perSquaredMetre_ * squaredMetres;
        if (uniform_ == 0 || gaussian == 0) return gaussian;
        return std::log((1 - uniform_) * std::exp(gaussian) + uniform_);
    }

 private:
    double perSquaredMetre_, uniform_;
};

}  // namespace

template <int Dim>
double endPointLogLikelihood(const RayBundle<Dim>& rays, DistanceField<Dim>& field,
                             const typename DistanceField<Dim>::Source& source,
                             const TLikelihoodOptions& options) {
    using Field = DistanceField<Dim>;
    const auto& geometry = source.map.geometry();
    std::vector<Cell<Dim>> cells;
    std::vector<std::size_t> hits;
    cells.reserve(rays.size());
    hits.reserve(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (rays.kind(i) != RayEnd::hit) continue;
        hits.push_back(i);
        cells.push_back(geometry.cellOf(rays.end(i)));
    }
    std::vector<typename Field::Code> codes(cells.size());
    field.nearest(source, Field::reachFor(options.maxDistance, geometry.resolution()),
                  cells.data(), cells.size(), codes.data());

    const PointScore score(options);
    const double farthest = score(options.maxDistance * options.maxDistance);
    const double unknown = std::log(options.unknownLikelihood);
    double sum = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        // The cell of the point itself has distance 0, whatever rounding says.
        if (codes[i].squaredCells() == 0) continue;
        double distance = options.maxDistance;
        if (codes[i].found()) {
            Cell<Dim> cell = codes[i].offset();
            for (std::size_t a = 0; a < Dim; ++a) cell[a] += cells[i][a];
            distance = distanceToCell<Dim>(rays.end(hits[i]), cell, geometry);
        }
        if (distance < options.maxDistance)
            sum += score(distance * distance);
        else
            sum += source.map.logOdds(cells[i]) ? farthest : unknown;
    }
    // Otherwise a pose that throws points out of the map would win.
    return sum + farthest * static_cast<double>(rays.skipped().outOfRange);
}

#define SUPERRAY_INSTANTIATE(Dim)                                                          \
    template double endPointLogLikelihood<Dim>(const RayBundle<Dim>&, DistanceField<Dim>&, \
                                               const DistanceField<Dim>::Source&,          \
                                               const TLikelihoodOptions&);
SUPERRAY_INSTANTIATE(2)
SUPERRAY_INSTANTIATE(3)
#undef SUPERRAY_INSTANTIATE

}  // namespace superray
