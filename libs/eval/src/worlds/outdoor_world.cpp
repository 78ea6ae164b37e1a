// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/seeded_random.h>

#include "worlds/world_plans.h"

namespace superray {
namespace {

constexpr double kBelowGround = 4;  // [m] foundations: the ground slopes

/// True if the place is free of the path by `margin`.
bool clearOfPath(const std::vector<Eigen::Vector2d>& path, const Eigen::Vector2d& place,
                 double margin) {
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
        const Eigen::Vector2d along = path[i + 1] - path[i];
        const double t =
            std::min(1.0, std::max(0.0, (place - path[i]).dot(along) / along.squaredNorm()));
        if ((place - path[i] - t * along).norm() < margin) return false;
    }
    return true;
}

/// A box on the ground around `centre`, if it keeps clear of the path.
void addBlock(WorldPlan& plan, const Eigen::Vector2d& centre, const Eigen::Vector2d& size,
              double height, double margin) {
    const Eigen::Vector2d low = centre - 0.5 * size, high = centre + 0.5 * size;
    // Points along its outline are as close as it comes.
    for (double t = 0; t <= 1; t += 0.05) {
        const Eigen::Vector2d p = low + t * (high - low);
        for (const Eigen::Vector2d& q :
             {Eigen::Vector2d(p.x(), low.y()), Eigen::Vector2d(p.x(), high.y()),
              Eigen::Vector2d(low.x(), p.y()), Eigen::Vector2d(high.x(), p.y())})
            if (!clearOfPath(plan.path, q, margin)) return;
    }
    const double ground = plan.scene.groundAt(centre.x(), centre.y());
    plan.scene.boxes.push_back(
        {{low.x(), low.y(), ground - kBelowGround}, {high.x(), high.y(), ground + height}});
}

void addTree(WorldPlan& plan, const Eigen::Vector2d& place, SeededRandom& random) {
    const double ground = plan.scene.groundAt(place.x(), place.y());
    const double trunk = random.uniform(1.8, 3.2), crown = random.uniform(1.1, 2.3);
    plan.scene.cylinders.push_back({place, random.uniform(0.11, 0.28), ground - kBelowGround,
                                    ground + trunk + 0.5 * crown});
    // A crown of several balls, so that it is not smooth.
    for (int i = 0; i < 5; ++i) {
        const Eigen::Vector3d offset(random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6),
                                     random.uniform(0.2, 1.4));
        plan.scene.balls.push_back(
            {Eigen::Vector3d(place.x(), place.y(), ground + trunk) + crown * offset,
             crown * random.uniform(0.45, 0.75)});
    }
}

}  // namespace

WorldPlan planOutdoor(std::uint64_t seed) {
    WorldPlan plan;
    SeededRandom random(seed, 2);
    plan.scene.groundZ = 0.031;
    plan.scene.groundSlope = {0.011, -0.007};
    // A walk between buildings, round a corner.
    plan.path = {{-78, -3}, {-6, 1}, {40, 2}, {48, 8}, {50, 75}};

    // Buildings along the way, and some farther off.
    for (double x = -87; x < 100; x += 21) {
        for (const double side : {1.0, -1.0}) {
            const Eigen::Vector2d centre(x + random.uniform(-2, 2),
                                         side * random.uniform(15, 19));
            addBlock(plan, centre, {random.uniform(13, 18), random.uniform(9, 14)},
                     random.uniform(5, 13), 5);
        }
    }
    for (const double y : {34.0, 55.0, -42.0})
        for (double x = -70; x < 100; x += 26)
            addBlock(plan, {x + random.uniform(-4, 4), y + random.uniform(-3, 3)},
                     {random.uniform(10, 20), random.uniform(8, 16)}, random.uniform(4, 15), 5);

    const auto anywhere = [&] {
        const double x = random.uniform(-85, 95);
        return Eigen::Vector2d(x, random.uniform(-60, 85));
    };
    // Parked cars, hedges, trees and lamp posts.
    for (int i = 0; i < 30; ++i)
        addBlock(plan, anywhere(), {4.3, 1.77}, random.uniform(1.3, 1.7), 2.5);
    for (int i = 0; i < 25; ++i)
        addBlock(plan, anywhere(), {random.uniform(2, 9), 0.8}, random.uniform(0.7, 1.4), 2);
    for (int i = 0; i < 140; ++i) {
        const Eigen::Vector2d place = anywhere();
        if (clearOfPath(plan.path, place, 4)) addTree(plan, place, random);
    }
    for (int i = 0; i < 40; ++i) {
        const Eigen::Vector2d place = anywhere();
        const double ground = plan.scene.groundAt(place.x(), place.y());
        if (clearOfPath(plan.path, place, 1.5))
            plan.scene.cylinders.push_back({place, 0.09, ground - kBelowGround, ground + 6.2});
    }

    plan.sensor = {1700, 256, -0.06, 0.075, 80, 0.015, {0.2, 0.05, 1.73}, -0.01, 0.1};
    plan.scans = 81;
    plan.pointsPerScan = 247817;
    return plan;
}

}  // namespace superray
