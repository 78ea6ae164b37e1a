// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file incidence.h
/// At which angle rays meet the surfaces of a simulated world.

#include <superray/eval/simulated_world.h>

#include <optional>

namespace superray {

/// Angle between a ray and the normal of the first surface that it meets [degrees, 0 to
/// 90], by casting two rays beside it. Nothing where a ray meets none.
/// \param origin in free space [m]
/// \pre direction has length > 0 and is not within 0.01 degrees of the vertical
std::optional<double> incidenceOf(const SimulatedWorld& world, const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction, std::size_t scan = 0);

}  // namespace superray
