#pragma once
/// \file likelihood.h
/// How well a scan agrees with a map.

#include <superray/core/ray_bundle.h>
#include <superray/maps/options.h>

#include "queries/distance_field.h"

namespace superray {

/// Distance from a point to a cell's box [m], 0 inside.
template <int Dim>
double distanceToCell(const Point<Dim>& p, const Cell<Dim>& cell,
                      const CellGeometry<Dim>& geometry);

/// Log-likelihood of the hits; see TLikelihoodOptions. Points that cannot be
/// addressed score as if they were far from anything.
template <int Dim>
double endPointLogLikelihood(const RayBundle<Dim>& rays, DistanceField<Dim>& field,
                             const typename DistanceField<Dim>::Source& source,
                             const TLikelihoodOptions& options);

}  // namespace superray
