// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file likelihood.h
/// How well a scan agrees with a map.

#include <superray/core/ray_bundle.h>
#include <superray/maps/options.h>

#include "queries/distance_field.h"

namespace superray {

/// Log-likelihood of the hits; see TLikelihoodOptions. Points that cannot be
/// addressed score as if they were far from anything.
template <int Dim>
double endPointLogLikelihood(const RayBundle<Dim>& rays, DistanceField<Dim>& field,
                             const typename DistanceField<Dim>::Source& source,
                             const TLikelihoodOptions& options);

}  // namespace superray
