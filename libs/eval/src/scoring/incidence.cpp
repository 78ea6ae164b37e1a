// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/incidence.h>

#include <algorithm>
#include <cmath>

namespace superray {
namespace {

/// Angle between a ray and those cast beside it [rad]: small, so that few of them meet
/// another surface, and large enough for the precision of the distances.
constexpr double kBeside = 1e-5;
constexpr double kDegreesPerRadian = 57.29577951308232;

}  // namespace

std::optional<double> incidenceOf(const SimulatedWorld& world, const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction, std::size_t scan) {
    const Eigen::Vector3d ray = direction.normalized();
    const Eigen::Vector3d side = ray.cross(Eigen::Vector3d::UnitZ()).normalized();
    const Eigen::Vector3d rays[3] = {ray, ray + kBeside * side,
                                     ray + kBeside * side.cross(ray)};
    Eigen::Vector3d ends[3];
    for (int i = 0; i < 3; ++i) {
        const auto distance = world.castRay(origin, rays[i], scan);
        if (!distance) return std::nullopt;
        ends[i] = rays[i].normalized() * *distance;
    }
    const Eigen::Vector3d normal = (ends[1] - ends[0]).cross(ends[2] - ends[0]).normalized();
    return std::acos(std::min(1.0, std::abs(normal.dot(ray)))) * kDegreesPerRadian;
}

}  // namespace superray
