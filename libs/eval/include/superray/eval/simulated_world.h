// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file simulated_world.h
/// Seeded worlds made of solids, and a sensor that moves through them. Ray
/// casting is analytic, so that the truth is known exactly, at any point.

#include <mrpt/poses/CPose3D.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
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

/// Whether end points have the sensor's noise, or lie on the surface.
enum class RangeNoise : std::uint8_t { measured, none };

/// What a surface belongs to.
enum class SolidKind : std::uint8_t { fixed, walker, removed };

/// A world, the same for the same name and seed. Like those of the paper:
///
///  - `indoor`: a corridor with furnished rooms; 66 scans of 89,446 points;
///  - `outdoor`: a campus with buildings, trees, poles and cars on sloping
///    ground; 81 scans of 247,817 points, ranges to 80 m.
///
/// And one with moving things:
///
///  - `walker`: a hall, a sensor that stands still, a cylinder that walks by in
///    steps of 0.12 m a scan, and a box that is gone after half of the scans;
///    60 scans of 131,072 points.
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
    SimulatedScan scan(std::size_t index, RangeNoise noise = RangeNoise::measured) const;

    // Ground truth, map frame [m], as it is during a scan. \pre scan < scanCount()
    /// True if the point lies in a solid (or in the ground).
    bool occupied(const Eigen::Vector3d& point, std::size_t scan = 0) const;
    /// True if a closed box shares a point with a solid (or with the ground).
    bool touches(const Eigen::AlignedBox3d& box, std::size_t scan = 0) const;
    /// The same for each of parts^3 equal parts of a box; x counts fastest, then y.
    std::vector<bool> touchedParts(const Eigen::AlignedBox3d& box, int parts,
                                   std::size_t scan = 0) const;
    /// Distance from `origin` (in free space) to the first surface along
    /// `direction`; nothing if there is none within the sensor's range.
    /// \pre direction has length > 0 and is not vertical
    std::optional<double> castRay(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction, std::size_t scan = 0) const;

    // Of worlds with moving things.
    bool moves() const;
    /// True if a closed box shares a point with what is there in every scan.
    bool touchesFixed(const Eigen::AlignedBox3d& box) const;
    /// Whose surface the point is on, to a millimetre.
    SolidKind kindOfSurface(const Eigen::Vector3d& point, std::size_t scan) const;
    /// First scan without the removed box. \pre moves()
    std::size_t removalScan() const;

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace superray
