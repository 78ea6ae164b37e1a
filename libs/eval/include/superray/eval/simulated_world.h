// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file simulated_world.h
/// Seeded worlds made of solids, and a sensor that moves through them. Ray
/// casting is analytic, so that the truth is known exactly, at any point.

#include <mrpt/poses/CPose3D.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace superray {

/// One scan of the simulated sensor.
struct SimulatedScan {
    double seconds = 0;                   ///< since the first scan
    mrpt::poses::CPose3D T_map_robot;     ///< exact
    mrpt::poses::CPose3D T_robot_sensor;  ///< the same for all scans
    std::vector<Eigen::Vector3f> points;  ///< end points [m, sensor frame]
};

/// A world like the paper's, the same for the same name and seed:
///
///  - `indoor`: a corridor with furnished rooms; 66 scans of 89,446 points;
///  - `outdoor`: a campus with buildings, trees, poles and cars on sloping
///    ground; 81 scans of 247,817 points, ranges to 80 m.
///
/// The sensor spins: columns of beams, one after the other. Beams that meet
/// nothing within its range give no point; of the others, evenly chosen, the
/// number above is delivered.
class SimulatedWorld {
 public:
    static constexpr std::uint64_t kDefaultSeed = 1;

    /// Names of the worlds.
    static const std::vector<std::string>& names();
    static bool isName(const std::string& name);

    /// \throws InputError for an unknown name
    explicit SimulatedWorld(const std::string& name, std::uint64_t seed = kDefaultSeed);
    ~SimulatedWorld();
    SimulatedWorld(SimulatedWorld&&) noexcept;
    SimulatedWorld& operator=(SimulatedWorld&&) noexcept;

    const std::string& name() const;
    std::size_t scanCount() const;
    std::size_t pointsPerScan() const;
    /// Range noise never exceeds this [m].
    double largestNoise() const;
    /// Any scan, in any order. \pre index < scanCount()
    SimulatedScan scan(std::size_t index) const;

    // Ground truth, map frame [m].
    /// True if the point lies in a solid (or in the ground).
    bool occupied(const Eigen::Vector3d& point) const;
    /// Distance from `origin` (in free space) to the first surface along
    /// `direction`; nothing if there is none within the sensor's range.
    /// \pre direction has length > 0 and is not vertical
    std::optional<double> castRay(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const;

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace superray
