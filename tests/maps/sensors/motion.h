// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A fast robot and a tilted sensor on it, as formulas.

#include <mrpt/poses/CPose3DInterpolator.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>

namespace superray::test {

using mrpt::poses::CPose3D;

/// 12 m/s forwards (and a little aside and upwards) in a curve of 80 degrees per
/// second, as formulas; the trajectory has knots of it.
struct Motion {
    Eigen::Vector3d start{3, -2, 0.5}, velocity{11, -4, 0.7};
    double yaw = 0.4, yawRate = 1.4, pitch = 0.1, roll = -0.05;

    Eigen::Matrix3d rotation(double t) const {
        return (Eigen::AngleAxisd(yaw + yawRate * t, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    }
    Eigen::Vector3d position(double t) const { return start + velocity * t; }
    CPose3D pose(double t) const {
        const Eigen::Vector3d p = position(t);
        return {p.x(), p.y(), p.z(), yaw + yawRate * t, pitch, roll};
    }
    /// Knots at irregular times from `first` to `last` [s] after `stamp`.
    mrpt::poses::CPose3DInterpolator knots(mrpt::Clock::time_point stamp, double first,
                                           double last) const {
        mrpt::poses::CPose3DInterpolator trajectory;
        const auto insert = [&](double t) {
            // The clock counts in 100 ns.
            const auto ticks = static_cast<std::int64_t>(std::llround(t * 1e7));
            trajectory.insert(stamp + mrpt::Clock::duration(ticks),
                              pose(static_cast<double>(ticks) * 1e-7));
        };
        for (double t = first; t < last; t += 0.007 + 0.004 * std::sin(50 * t)) insert(t);
        insert(last);
        return trajectory;
    }
};

/// Sensor on the robot as matrices, made from angles anew.
struct Mounting {
    Eigen::Vector3d at{0.2, -0.1, 1.1};
    Eigen::Matrix3d R = (Eigen::AngleAxisd(-0.4, Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(0.25, Eigen::Vector3d::UnitY()) *
                         Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitX()))
                            .toRotationMatrix();
    static CPose3D pose() { return {0.2, -0.1, 1.1, -0.4, 0.25, -0.2}; }
};

}  // namespace superray::test
