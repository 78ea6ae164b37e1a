// SPDX-License-Identifier: BSD-3-Clause
#include "sensors/camera_directions.h"

#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <mutex>
#include <sstream>
#include <stdexcept>

namespace superray {
namespace {

using mrpt::img::DistortionModel;
using mrpt::img::TCamera;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Normalised image coordinates with plumb_bob distortion to those without, by
/// fixed-point iteration of the forward model (the usual way; its closed form
/// has no inverse). NaN if it does not converge.
Eigen::Vector2d undistortPlumbBob(const Eigen::Vector2d& distorted, const TCamera& camera) {
    const auto& d = camera.dist;  // k1 k2 p1 p2 k3 k4 k5 k6
    Eigen::Vector2d p = distorted;
    for (int i = 0; i < 200; ++i) {
        const double r2 = p.squaredNorm(), r4 = r2 * r2, r6 = r4 * r2;
        const double radial =
            (1 + d[0] * r2 + d[1] * r4 + d[4] * r6) / (1 + d[5] * r2 + d[6] * r4 + d[7] * r6);
        const double xy = p.x() * p.y();
        const Eigen::Vector2d tangential(2 * d[2] * xy + d[3] * (r2 + 2 * p.x() * p.x()),
                                         d[2] * (r2 + 2 * p.y() * p.y()) + 2 * d[3] * xy);
        const Eigen::Vector2d next = (distorted - tangential) / radial;
        const double change = (next - p).squaredNorm();
        p = next;
        if (change < 1e-24) return p;
    }
    return {kNaN, kNaN};
}

/// Direction in the camera frame (z forward) of Kannala-Brandt coordinates.
Eigen::Vector3d directionKannalaBrandt(const Eigen::Vector2d& distorted,
                                       const TCamera& camera) {
    const auto& d = camera.dist;  // k1 k2 - - k3 k4
    const double target = distorted.norm();
    if (target == 0) return {0, 0, 1};
    // Newton for theta (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8) = target
    double theta = target;
    for (int i = 0; i < 100; ++i) {
        const double t2 = theta * theta, t4 = t2 * t2, t6 = t4 * t2, t8 = t4 * t4;
        const double value = theta * (1 + d[0] * t2 + d[1] * t4 + d[4] * t6 + d[5] * t8);
        const double slope = 1 + 3 * d[0] * t2 + 5 * d[1] * t4 + 7 * d[4] * t6 + 9 * d[5] * t8;
        const double step = (value - target) / slope;
        theta -= step;
        if (std::abs(step) < 1e-12 && theta > 0 && theta < M_PI) {
            const Eigen::Vector2d side = distorted / target * std::sin(theta);
            return {side.x(), side.y(), std::cos(theta)};
        }
    }
    return {kNaN, kNaN, kNaN};
}

/// Direction in the camera frame: x right, y down, z forward.
Eigen::Vector3d cameraDirection(double column, double row, const TCamera& camera) {
    const Eigen::Vector2d p((column - camera.cx()) / camera.fx(),
                            (row - camera.cy()) / camera.fy());
    switch (camera.distortion) {
        case DistortionModel::none:
            return {p.x(), p.y(), 1};
        case DistortionModel::plumb_bob: {
            const Eigen::Vector2d u = undistortPlumbBob(p, camera);
            return {u.x(), u.y(), 1};
        }
        case DistortionModel::kannala_brandt:
            return directionKannalaBrandt(p, camera);
    }
    return {kNaN, kNaN, kNaN};
}

PixelDirections compute(const TCamera& camera, RangeKind kind) {
    PixelDirections directions;
    directions.reserve(std::size_t{camera.nrows} * camera.ncols);
    for (std::uint32_t row = 0; row < camera.nrows; ++row)
        for (std::uint32_t column = 0; column < camera.ncols; ++column) {
            const Eigen::Vector3d c = cameraDirection(column, row, camera);
            const Eigen::Vector3d sensor(c.z(), -c.x(), -c.y());
            // A depth says nothing about directions sideways or behind.
            const double scale = kind == RangeKind::range ? 1 / sensor.norm()
                                 : sensor.x() > 1e-6      ? 1 / sensor.x()
                                                          : kNaN;
            directions.push_back((sensor * scale).cast<float>());
        }
    return directions;
}

/// All that compute() depends on.
struct Key {
    std::array<double, 4> intrinsics;
    std::array<double, 8> distortion;
    DistortionModel model;
    std::uint32_t rows, columns;
    RangeKind kind;
    bool operator==(const Key& o) const {
        return intrinsics == o.intrinsics && distortion == o.distortion && model == o.model &&
               rows == o.rows && columns == o.columns && kind == o.kind;
    }
};

}  // namespace

std::shared_ptr<const PixelDirections> pixelDirections(const TCamera& camera, RangeKind kind) {
    if (!(camera.fx() > 0 && camera.fy() > 0)) {
        std::ostringstream message;
        message << "range camera: focal lengths fx = " << camera.fx()
                << ", fy = " << camera.fy() << ": must be > 0";
        throw std::invalid_argument(message.str());
    }
    struct Entry {
        Key key;
        std::shared_ptr<const PixelDirections> directions;
    };
    constexpr std::size_t kKept = 8;
    static std::mutex mutex;
    static std::deque<Entry> cache;

    const Key key{{camera.fx(), camera.fy(), camera.cx(), camera.cy()},
                  camera.dist,
                  camera.distortion,
                  camera.nrows,
                  camera.ncols,
                  kind};
    const std::lock_guard<std::mutex> lock(mutex);
    for (const Entry& e : cache)
        if (e.key == key) return e.directions;
    cache.push_front({key, std::make_shared<const PixelDirections>(compute(camera, kind))});
    if (cache.size() > kKept) cache.pop_back();
    return cache.front().directions;
}

}  // namespace superray
