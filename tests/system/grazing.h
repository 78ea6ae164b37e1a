// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file grazing.h
/// How far a ray reaches into a cell, or misses it by: plain geometry in long
/// double, with nothing in common with the walks that are compared.

#include <superray/core/cell.h>

#include <algorithm>
#include <array>
#include <vector>

namespace superray::test {

/// A ray in cell units, as exactly as long double has it.
struct ScaledRay {
    std::array<long double, 3> from, extent;

    ScaledRay(const Point<3>& origin, const Point<3>& end, double resolution) {
        for (std::size_t a = 0; a < 3; ++a) {
            const auto i = static_cast<Eigen::Index>(a);
            const long double start = static_cast<long double>(origin[i]) / resolution;
            from[a] = start;
            extent[a] = static_cast<long double>(end[i]) / resolution - start;
        }
    }
    long double length() const {
        return std::sqrt(extent[0] * extent[0] + extent[1] * extent[1] + extent[2] * extent[2]);
    }
};

/// Distance of a point of the ray to one face of a cell, positive on the inner
/// side, as the linear function `at0 + slope t`, t in [0, 1].
struct FaceDistance {
    long double at0, slope;
    long double at(long double t) const { return at0 + slope * t; }
};

inline std::array<FaceDistance, 6> faceDistances(const ScaledRay& ray, const Cell<3>& cell) {
    std::array<FaceDistance, 6> faces;
    for (std::size_t a = 0; a < 3; ++a) {
        faces[2 * a] = {ray.from[a] - cell[a], ray.extent[a]};
        faces[2 * a + 1] = {cell[a] + 1 - ray.from[a], -ray.extent[a]};
    }
    return faces;
}

/// Depth [cells] that the ray reaches inside the cell: the largest distance of
/// any of its points to the nearest face. Negative if the ray misses the cell:
/// minus the (maximum norm) distance by which it does.
inline long double depthInCell(const ScaledRay& ray, const Cell<3>& cell) {
    const auto faces = faceDistances(ray, cell);
    const auto depthAt = [&](long double t) {
        long double depth = faces[0].at(t);
        for (const FaceDistance& f : faces) depth = std::min(depth, f.at(t));
        return depth;
    };
    // The minimum of linear functions is largest at an end or where two cross.
    long double deepest = std::max(depthAt(0), depthAt(1));
    for (std::size_t i = 0; i < faces.size(); ++i) {
        for (std::size_t j = i + 1; j < faces.size(); ++j) {
            if (faces[i].slope == faces[j].slope) continue;
            const long double t =
                (faces[j].at0 - faces[i].at0) / (faces[i].slope - faces[j].slope);
            if (t > 0 && t < 1) deepest = std::max(deepest, depthAt(t));
        }
    }
    return deepest;
}

/// Length of the ray [cells] from where it leaves the cell to its end point.
inline long double lengthAfterCell(const ScaledRay& ray, const Cell<3>& cell) {
    long double leaves = 1;
    for (const FaceDistance& f : faceDistances(ray, cell))
        if (f.slope < 0) leaves = std::min(leaves, f.at0 / -f.slope);
    return (1 - leaves) * ray.length();
}

}  // namespace superray::test
