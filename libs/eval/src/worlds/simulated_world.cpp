// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/poses/CPose3DQuat.h>
#include <superray/eval/input_error.h>
#include <superray/eval/seeded_random.h>
#include <superray/eval/simulated_world.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "worlds/world_plans.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

/// Cosine and sine of an angle in turns, by additions and multiplications
/// only: those of the C library differ in the last bit between versions.
Eigen::Vector2d unitVector(double turns) {
    const double quarters = std::floor(4 * turns + 0.5);
    const double x = (turns - 0.25 * quarters) * 6.283185307179586;  // |x| <= pi / 4
    double sine = 0, cosine = 0, term = 1;
    for (int n = 0; n < 20; n += 2) {
        cosine += term;
        term *= x / (n + 1);
        sine += term;
        term *= -x / (n + 2);
    }
    switch (static_cast<long long>(quarters) & 3) {
        case 0:
            return {cosine, sine};
        case 1:
            return {-sine, cosine};
        case 2:
            return {-cosine, -sine};
        default:
            return {sine, -cosine};
    }
}

/// Turned about the upright axis. Recordings store quaternions: the pose is the
/// one that comes back from them.
CPose3D uprightPose(const Eigen::Vector3d& position, const Eigen::Vector2d& heading) {
    mrpt::math::CMatrixDouble33 rotation = mrpt::math::CMatrixDouble33::Identity();
    rotation(0, 0) = rotation(1, 1) = heading.x();
    rotation(0, 1) = -heading.y();
    rotation(1, 0) = heading.y();
    const CPose3D pose(rotation,
                       mrpt::math::TPoint3D(position.x(), position.y(), position.z()));
    return CPose3D(mrpt::poses::CPose3DQuat(pose));
}

Eigen::Vector2d rotated(const Eigen::Vector2d& v, const Eigen::Vector2d& by) {
    return {v.x() * by.x() - v.y() * by.y(), v.x() * by.y() + v.y() * by.x()};
}

struct PlaceOnPath {
    Eigen::Vector2d position, heading;
};

/// The place at the share `t` of the whole length, t in [0, 1].
PlaceOnPath along(const std::vector<Eigen::Vector2d>& path, double t) {
    double length = 0;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) length += (path[i + 1] - path[i]).norm();
    if (length == 0) return {path.front(), {1, 0}};  // stands still
    double left = t * length;
    for (std::size_t i = 0;; ++i) {
        const Eigen::Vector2d step = path[i + 1] - path[i];
        const double stepLength = step.norm();
        if (left <= stepLength || i + 2 == path.size())
            return {path[i] + step * std::min(1.0, left / stepLength), step / stepLength};
        left -= stepLength;
    }
}

WorldPlan planOf(const std::string& name, std::uint64_t seed) {
    if (name == "indoor") return planIndoor(seed);
    if (name == "outdoor") return planOutdoor(seed);
    if (name == "walker") return planWalker(seed);
    throw InputError("unknown world '" + name + "': must be indoor, outdoor or walker");
}

std::vector<SolidScene> scenesOf(const WorldPlan& plan) {
    if (!plan.moving) return {plan.scene};
    std::vector<SolidScene> scenes;
    for (std::size_t i = 0; i < plan.scans; ++i) {
        SolidScene scene = plan.scene;
        scene.cylinders.push_back(plan.moving->walkerAt(i));
        if (i < plan.moving->removalScan) scene.boxes.push_back(plan.moving->removed);
        scenes.push_back(std::move(scene));
    }
    return scenes;
}

}  // namespace

struct SimulatedWorld::Impl {
    std::string name;
    std::uint64_t seed;
    WorldPlan plan;
    std::vector<Eigen::Vector2d> beams;  // (horizontal, vertical) part of unit vectors
    std::vector<SolidScene> scenes;      // of each scan if things move, else one

    const SolidScene& sceneAt(std::size_t scan) const {
        return scenes[std::min(scan, scenes.size() - 1)];
    }

    /// Returns of one turn [m, sensor frame], as the sensor delivers them.
    std::vector<Eigen::Vector3f> turn(const CPose3D& T_map_sensor,
                                      const Eigen::Vector2d& heading, int columns,
                                      const SolidScene& scene, RangeNoise noise,
                                      SeededRandom random) const;
};

const std::vector<std::string>& SimulatedWorld::names() {
    static const std::vector<std::string> all = {"indoor", "outdoor", "walker"};
    return all;
}

bool SimulatedWorld::isName(const std::string& name) {
    return std::find(names().begin(), names().end(), name) != names().end();
}

SimulatedWorld::SimulatedWorld(const std::string& name, std::uint64_t seed)
    : impl_(std::make_unique<Impl>(Impl{name, seed, planOf(name, seed), {}, {}})) {
    const SpinningSensor& sensor = impl_->plan.sensor;
    for (int i = 0; i < sensor.beams; ++i)
        impl_->beams.push_back(
            unitVector(sensor.lowestBeam +
                       (sensor.highestBeam - sensor.lowestBeam) * i / (sensor.beams - 1)));
    impl_->scenes = scenesOf(impl_->plan);
}
SimulatedWorld::~SimulatedWorld() = default;
SimulatedWorld::SimulatedWorld(SimulatedWorld&&) noexcept = default;
SimulatedWorld& SimulatedWorld::operator=(SimulatedWorld&&) noexcept = default;

const std::string& SimulatedWorld::name() const {
    return impl_->name;
}
std::size_t SimulatedWorld::scanCount() const {
    return impl_->plan.scans;
}
std::size_t SimulatedWorld::pointsPerScan() const {
    return impl_->plan.pointsPerScan;
}
double SimulatedWorld::largestNoise() const {
    return impl_->plan.sensor.noise * SeededRandom::kBellBound;
}

std::vector<Eigen::Vector3f> SimulatedWorld::Impl::turn(const CPose3D& T_map_sensor,
                                                        const Eigen::Vector2d& heading,
                                                        int columns, const SolidScene& scene,
                                                        RangeNoise noise,
                                                        SeededRandom random) const {
    const SpinningSensor& sensor = plan.sensor;
    const Eigen::Vector3d origin(T_map_sensor.x(), T_map_sensor.y(), T_map_sensor.z());
    ScenePlane plane;
    std::vector<Eigen::Vector3f> returns;
    returns.reserve(static_cast<std::size_t>(columns) * beams.size());
    for (int column = 0; column < columns; ++column) {
        // Clockwise, as most spinning sensors do.
        const Eigen::Vector2d azimuth = unitVector(-(column + 0.5) / columns);
        scene.cut(origin, rotated(azimuth, heading), sensor.range, plane);
        for (const Eigen::Vector2d& beam : beams) {
            const double range = plane.cast(beam.y() / beam.x()) / beam.x();
            if (!(range <= sensor.range)) continue;
            const double error = random.bell(sensor.noise);
            const double measured = noise == RangeNoise::measured ? range + error : range;
            const Eigen::Vector3d point(azimuth.x() * beam.x() * measured,
                                        azimuth.y() * beam.x() * measured, beam.y() * measured);
            returns.push_back(point.cast<float>());
        }
    }
    return returns;
}

SimulatedScan SimulatedWorld::scan(std::size_t index, RangeNoise noise) const {
    const WorldPlan& plan = impl_->plan;
    const SpinningSensor& sensor = plan.sensor;
    SimulatedScan scan;
    scan.seconds = sensor.secondsPerScan * static_cast<double>(index);
    const PlaceOnPath place =
        along(plan.path, static_cast<double>(index) / static_cast<double>(plan.scans - 1));
    const Eigen::Vector2d& at = place.position;
    scan.T_map_robot =
        uprightPose({at.x(), at.y(), plan.scene.groundAt(at.x(), at.y())}, place.heading);
    const Eigen::Vector2d mounted = unitVector(sensor.yawOnRobot);
    scan.T_robot_sensor = uprightPose(sensor.positionOnRobot, mounted);

    // Where much of the sky is open, the sensor turns more slowly.
    std::vector<Eigen::Vector3f> returns;
    const std::size_t wanted = plan.pointsPerScan;
    for (int columns = sensor.columns; returns.size() < wanted; columns += columns / 4)
        returns = impl_->turn(scan.T_map_robot + scan.T_robot_sensor,
                              rotated(mounted, place.heading), columns, impl_->sceneAt(index),
                              noise, SeededRandom(impl_->seed, 1000 + index));
    // Keep the number that was promised, evenly.
    const std::size_t found = returns.size();
    scan.points.reserve(wanted);
    for (std::size_t i = 0; i < found; ++i)
        if ((i + 1) * wanted / found > i * wanted / found) scan.points.push_back(returns[i]);
    return scan;
}

bool SimulatedWorld::occupied(const Eigen::Vector3d& point, std::size_t scan) const {
    return impl_->sceneAt(scan).occupied(point);
}

bool SimulatedWorld::touches(const Eigen::AlignedBox3d& box, std::size_t scan) const {
    return impl_->sceneAt(scan).touches(box);
}

std::vector<bool> SimulatedWorld::touchedParts(const Eigen::AlignedBox3d& box, int parts,
                                               std::size_t scan) const {
    const SolidScene scene = impl_->sceneAt(scan).near(box);
    const Eigen::Vector3d edge = box.sizes() / parts;
    std::vector<bool> touched;
    touched.reserve(static_cast<std::size_t>(parts) * static_cast<std::size_t>(parts) *
                    static_cast<std::size_t>(parts));
    for (int z = 0; z < parts; ++z)
        for (int y = 0; y < parts; ++y)
            for (int x = 0; x < parts; ++x) {
                const Eigen::Vector3d low =
                    box.min() + edge.cwiseProduct(Eigen::Vector3d(x, y, z));
                touched.push_back(scene.touches({low, low + edge}));
            }
    return touched;
}

std::optional<double> SimulatedWorld::castRay(const Eigen::Vector3d& origin,
                                              const Eigen::Vector3d& direction,
                                              std::size_t scan) const {
    const double horizontal = direction.head<2>().norm();
    const double range = impl_->plan.sensor.range;
    ScenePlane plane;
    impl_->sceneAt(scan).cut(origin, direction.head<2>() / horizontal, range, plane);
    const double distance =
        plane.cast(direction.z() / horizontal) * direction.norm() / horizontal;
    if (!(distance <= range)) return std::nullopt;
    return distance;
}

bool SimulatedWorld::moves() const {
    return impl_->plan.moving.has_value();
}

bool SimulatedWorld::touchesFixed(const Eigen::AlignedBox3d& box) const {
    return impl_->plan.scene.touches(box);
}

SolidKind SimulatedWorld::kindOfSurface(const Eigen::Vector3d& point, std::size_t scan) const {
    constexpr double kTolerance = 1e-3;  // m
    if (!moves()) return SolidKind::fixed;
    const MovingThings& moving = *impl_->plan.moving;
    const Eigen::AlignedBox3d around(point - Eigen::Vector3d::Constant(kTolerance),
                                     point + Eigen::Vector3d::Constant(kTolerance));
    SolidScene walker, removed;
    walker.groundZ = removed.groundZ = -std::numeric_limits<double>::infinity();
    walker.cylinders = {moving.walkerAt(scan)};
    removed.boxes = {moving.removed};
    if (walker.touches(around)) return SolidKind::walker;
    if (scan < moving.removalScan && removed.touches(around)) return SolidKind::removed;
    return SolidKind::fixed;
}

std::size_t SimulatedWorld::removalScan() const {
    return impl_->plan.moving->removalScan;
}

}  // namespace superray
