// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file solid_scene.h
/// Solids that simulated worlds are made of, and rays cast against them.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace superray {

/// All solids are closed sets, in metres, in the map frame.
struct Box {
    Eigen::Vector3d low, high;
};
/// Upright.
struct Cylinder {
    Eigen::Vector2d centre;
    double radius, low, high;  // low, high: z
};
struct Ball {
    Eigen::Vector3d centre;
    double radius;
};

/// A vertical half-plane from the sensor outwards, in which a column of beams
/// lies: what its solids look like there.
struct ScenePlane {
    /// Solid from u0 to u1 (horizontal distance) and z0 to z1; for balls, the
    /// box around a disc of this squared radius and centre.
    struct Section {
        double u0, u1, z0, z1;
        double discU = 0, discZ = 0, discRadius2 = -1;  // < 0: the whole rectangle
    };
    std::vector<Section> sections;        // ordered by u0
    double sensorZ = 0;                   // height of the sensor
    double groundZ = 0, groundSlope = 0;  // ground below the sensor, and per u

    /// Horizontal distance at which the beam z = sensorZ + slope u meets
    /// something; infinity if nothing.
    double cast(double slope) const;
};

class SolidScene {
 public:
    std::vector<Box> boxes;
    std::vector<Cylinder> cylinders;
    std::vector<Ball> balls;
    /// The ground fills z <= groundZ + slope . (x, y).
    double groundZ = 0;
    Eigen::Vector2d groundSlope = Eigen::Vector2d::Zero();

    double groundAt(double x, double y) const {
        return groundZ + groundSlope.x() * x + groundSlope.y() * y;
    }
    bool occupied(const Eigen::Vector3d& p) const;
    /// True if a closed box shares a point with a solid or the ground.
    bool touches(const Eigen::AlignedBox3d& box) const;
    /// The solids that share a point with a closed box, and the ground.
    SolidScene near(const Eigen::AlignedBox3d& box) const;
    /// The half-plane from `origin` towards the unit vector `direction`, as far
    /// as `range`. The origin must be in free space.
    void cut(const Eigen::Vector3d& origin, const Eigen::Vector2d& direction, double range,
             ScenePlane& plane) const;
};

}  // namespace superray
