// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Seeded rays for equivalence tests: random ones, and those that break walks.

#include <superray/core/ray_bundle.h>

#include <cstdint>
#include <random>
#include <vector>

namespace superray::test {

using Random = std::mt19937_64;

// The distributions of the standard library differ from one to the next.

/// [from, to), in steps of 2^-53 of the length.
inline double uniform(Random& random, double from, double to) {
    constexpr double kStep = 1.0 / (std::uint64_t{1} << 53);
    return from + (to - from) * (static_cast<double>(random() >> 11) * kStep);
}
/// From `from` to `to`, both included.
inline int integer(Random& random, int from, int to) {
    const auto choices = static_cast<std::uint64_t>(to - from) + 1;
    return from + static_cast<int>(random() % choices);
}

template <int Dim>
Point<Dim> uniformPoint(Random& random, double radius) {
    Point<Dim> p;
    for (int a = 0; a < Dim; ++a) p[a] = uniform(random, -radius, radius);
    return p;
}

enum class Scene { uniform, clustered, gridAligned, nearby, wall, patch, image };
inline constexpr Scene kScenes[] = {Scene::uniform, Scene::clustered, Scene::gridAligned,
                                    Scene::nearby,  Scene::wall,      Scene::patch,
                                    Scene::image};

/// A scan of `count` rays.
/// - uniform: end points anywhere
/// - clustered: many points in few cells (super rays)
/// - gridAligned: sensor and end points on faces, edges and corners of cells;
///   axis-aligned and diagonal rays, zero-length ones
/// - nearby: end points in the sensor's cell and its neighbours
/// - wall: a plane seen from far
/// - patch: a small piece of it, with a hundred points per cell (a depth image)
/// - image: the same as a sensor delivers it, row by row, with a step in depth
template <int Dim>
RayBundle<Dim> makeScan(Scene scene, Random& random, const CellGeometry<Dim>& g, int count) {
    const double r = g.resolution();
    const auto snapped = [&](Point<Dim> p) {  // to multiples of half a cell
        for (int a = 0; a < Dim; ++a)
            if (integer(random, 0, 3) > 0) p[a] = std::round(p[a] / r * 2) / 2 * r;
        return p;
    };
    Point<Dim> origin = uniformPoint<Dim>(random, 3 * r);
    if (scene == Scene::gridAligned) origin = snapped(origin);
    RayBundle<Dim> rays(g, origin);

    std::vector<Point<Dim>> centers;
    for (int i = 0; i < 1 + count / 60; ++i)
        centers.push_back(g.center(g.cellOf(uniformPoint<Dim>(random, 40 * r))));
    const double wallAt = uniform(random, 5 * r, 30 * r);
    const int wallAxis = integer(random, 0, Dim - 1);

    for (int i = 0; i < count; ++i) {
        Point<Dim> end = origin;
        switch (scene) {
            case Scene::uniform:
                end = uniformPoint<Dim>(random, 40 * r);
                break;
            case Scene::clustered:
                // Two statements: compilers evaluate operands in either order.
                end = centers[static_cast<std::size_t>(
                    integer(random, 0, static_cast<int>(centers.size()) - 1))];
                end += uniformPoint<Dim>(random, 0.5 * r);
                break;
            case Scene::gridAligned: {
                end = snapped(uniformPoint<Dim>(random, 20 * r));
                const int kind = integer(random, 0, 5);
                if (kind == 0) {  // axis-aligned
                    const int keep = integer(random, 0, Dim - 1);
                    for (int a = 0; a < Dim; ++a)
                        if (a != keep) end[a] = origin[a];
                } else if (kind == 1) {  // diagonal
                    const double d = integer(random, -15, 15) * r;
                    for (int a = 0; a < Dim; ++a)
                        end[a] = origin[a] + (integer(random, 0, 1) ? d : -d);
                } else if (kind == 2) {  // diagonal in a plane
                    end = origin;
                    const double d = integer(random, -30, 30) * r / 2;
                    end[0] += d;
                    end[Dim - 1] += integer(random, 0, 1) ? d : -d;
                } else if (kind == 3 && integer(random, 0, 3) == 0) {
                    end = origin;  // zero length
                }
                break;
            }
            case Scene::nearby:
                end = origin + uniformPoint<Dim>(random, 1.5 * r);
                break;
            case Scene::patch:
                end = origin + uniformPoint<Dim>(random, 1.5 * r);
                end[wallAxis] = origin[wallAxis] + wallAt + uniform(random, 0, 0.4 * r);
                break;
            case Scene::image: {
                // In units of the image's height; one row in 2D.
                const int rows = Dim == 2 ? 1 : 30, columns = count / rows;
                const double u = static_cast<double>(i % columns) / columns - 0.3;
                const double v = Dim == 2 ? 0.1 : i / columns / double{30} - 0.4;
                const double depth = wallAt * (u < 0.2 ? 1 : 0.6);
                end = origin;
                end[wallAxis] += depth;
                end[(wallAxis + 1) % Dim] += depth * u;
                if (Dim == 3) end[(wallAxis + 2) % Dim] += depth * v;
                break;
            }
            case Scene::wall:
                end = origin + uniformPoint<Dim>(random, 0.8 * wallAt);
                end[wallAxis] = origin[wallAxis] + wallAt + uniform(random, 0, 0.1 * r);
                break;
        }
        rays.add(end, integer(random, 0, 19) == 0 ? RayEnd::noReturn : RayEnd::hit);
    }
    return rays;
}

/// The same with end points in single precision, as which a bundle keeps them then.
template <int Dim>
RayBundle<Dim> rounded(const RayBundle<Dim>& scan) {
    RayBundle<Dim> rays(scan.geometry(), scan.commonOrigin());
    for (std::size_t i = 0; i < scan.size(); ++i)
        rays.add(scan.end(i).template cast<float>().template cast<double>(), scan.kind(i));
    return rays;
}

}  // namespace superray::test
