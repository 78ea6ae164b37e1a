// SPDX-License-Identifier: BSD-3-Clause
#include "worlds/solid_scene.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace superray {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Narrows [from, to] to where low <= origin + slope * t <= high.
void clip(double origin, double slope, double low, double high, double& from, double& to) {
    if (slope == 0) {
        if (origin < low || origin > high) to = -kInfinity;
        return;
    }
    const double a = (low - origin) / slope, b = (high - origin) / slope;
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
}

/// Where the beam enters a disc; infinity if it does not.
double enterDisc(const ScenePlane::Section& s, double sensorZ, double slope) {
    // |(u, sensorZ + slope u) - (discU, discZ)|^2 = discRadius2
    const double dz = sensorZ - s.discZ;
    const double a = 1 + slope * slope;
    const double b = slope * dz - s.discU;
    const double c = s.discU * s.discU + dz * dz - s.discRadius2;
    const double root = b * b - a * c;
    if (root < 0) return kInfinity;
    const double u = (-b - std::sqrt(root)) / a;
    return u > 0 ? u : kInfinity;
}

bool touch(const Box& b, const Eigen::AlignedBox3d& box) {
    return (b.low.array() <= box.max().array()).all() &&
           (b.high.array() >= box.min().array()).all();
}

bool touch(const Cylinder& c, const Eigen::AlignedBox3d& box) {
    if (c.low > box.max().z() || c.high < box.min().z()) return false;
    const Eigen::Vector2d nearest =
        c.centre.cwiseMax(box.min().head<2>()).cwiseMin(box.max().head<2>());
    return (nearest - c.centre).squaredNorm() <= c.radius * c.radius;
}

bool touch(const Ball& b, const Eigen::AlignedBox3d& box) {
    return box.squaredExteriorDistance(b.centre) <= b.radius * b.radius;
}

/// True if the ground rises to the box somewhere below it.
bool groundTouches(const SolidScene& scene, const Eigen::AlignedBox3d& box) {
    const double x = scene.groundSlope.x() > 0 ? box.max().x() : box.min().x();
    const double y = scene.groundSlope.y() > 0 ? box.max().y() : box.min().y();
    return box.min().z() <= scene.groundAt(x, y);
}

template <class Solid>
bool anyTouches(const std::vector<Solid>& solids, const Eigen::AlignedBox3d& box) {
    return std::any_of(solids.begin(), solids.end(),
                       [&](const Solid& s) { return touch(s, box); });
}

template <class Solid>
void copyNear(const std::vector<Solid>& from, const Eigen::AlignedBox3d& box,
              std::vector<Solid>& to) {
    std::copy_if(from.begin(), from.end(), std::back_inserter(to),
                 [&](const Solid& s) { return touch(s, box); });
}

}  // namespace

double ScenePlane::cast(double slope) const {
    double nearest = kInfinity;
    // sensorZ + slope u = groundZ + groundSlope u
    if (slope < groundSlope) nearest = (groundZ - sensorZ) / (slope - groundSlope);
    for (const Section& s : sections) {
        if (s.u0 >= nearest) break;
        double from = s.u0, to = s.u1;
        clip(sensorZ, slope, s.z0, s.z1, from, to);
        if (from > to) continue;
        nearest = std::min(nearest, s.discRadius2 < 0 ? from : enterDisc(s, sensorZ, slope));
    }
    return nearest;
}

bool SolidScene::occupied(const Eigen::Vector3d& p) const {
    if (p.z() <= groundAt(p.x(), p.y())) return true;
    for (const Box& b : boxes)
        if ((p.array() >= b.low.array()).all() && (p.array() <= b.high.array()).all())
            return true;
    for (const Cylinder& c : cylinders)
        if (p.z() >= c.low && p.z() <= c.high &&
            (p.head<2>() - c.centre).squaredNorm() <= c.radius * c.radius)
            return true;
    for (const Ball& b : balls)
        if ((p - b.centre).squaredNorm() <= b.radius * b.radius) return true;
    return false;
}

bool SolidScene::touches(const Eigen::AlignedBox3d& box) const {
    return groundTouches(*this, box) || anyTouches(boxes, box) || anyTouches(cylinders, box) ||
           anyTouches(balls, box);
}

SolidScene SolidScene::near(const Eigen::AlignedBox3d& box) const {
    SolidScene part;
    part.groundZ = groundZ;
    part.groundSlope = groundSlope;
    copyNear(boxes, box, part.boxes);
    copyNear(cylinders, box, part.cylinders);
    copyNear(balls, box, part.balls);
    return part;
}

void SolidScene::cut(const Eigen::Vector3d& origin, const Eigen::Vector2d& direction,
                     double range, ScenePlane& plane) const {
    plane.sections.clear();
    plane.sensorZ = origin.z();
    plane.groundZ = groundAt(origin.x(), origin.y());
    plane.groundSlope = groundSlope.dot(direction);
    const Eigen::Vector2d o = origin.head<2>();

    for (const Box& b : boxes) {
        double from = 0, to = range;
        clip(o.x(), direction.x(), b.low.x(), b.high.x(), from, to);
        clip(o.y(), direction.y(), b.low.y(), b.high.y(), from, to);
        if (from <= to) plane.sections.push_back({from, to, b.low.z(), b.high.z()});
    }
    // Distance along and squared distance beside the half-plane's base line.
    const auto seen = [&](const Eigen::Vector2d& centre, double radius, double& along,
                          double& half2) {
        const Eigen::Vector2d to = centre - o;
        along = to.dot(direction);
        const double beside = to.x() * direction.y() - to.y() * direction.x();
        half2 = radius * radius - beside * beside;
        return half2 >= 0 && along + radius > 0 && along - radius < range;
    };
    double along = 0, half2 = 0;
    for (const Cylinder& c : cylinders) {
        if (!seen(c.centre, c.radius, along, half2)) continue;
        const double half = std::sqrt(half2);
        if (along - half > 0)
            plane.sections.push_back({along - half, along + half, c.low, c.high});
    }
    for (const Ball& b : balls) {
        if (!seen(b.centre.head<2>(), b.radius, along, half2)) continue;
        const double half = std::sqrt(half2);
        plane.sections.push_back({std::max(0.0, along - half), along + half,
                                  b.centre.z() - half, b.centre.z() + half, along, b.centre.z(),
                                  half2});
    }
    std::sort(plane.sections.begin(), plane.sections.end(),
              [](const auto& a, const auto& b) { return a.u0 < b.u0; });
}

}  // namespace superray
