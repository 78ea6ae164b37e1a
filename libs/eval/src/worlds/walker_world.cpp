// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/seeded_random.h>

#include "worlds/world_plans.h"

namespace superray {
namespace {

// The hall [m], the sensor in its middle. Walls do not lie on multiples of cell edges.
constexpr double kHalfLength = 7.07, kHalfWidth = 5.13, kHeight = 3.07, kWall = 0.17;
constexpr std::size_t kScans = 60;
constexpr double kStep = 0.12;  // a scan: 1.2 m/s at ten scans a second

void addWalls(SolidScene& scene) {
    const double x = kHalfLength, y = kHalfWidth;
    scene.boxes.push_back({{-x - kWall, -y - kWall, 0}, {-x, y + kWall, kHeight}});
    scene.boxes.push_back({{x, -y - kWall, 0}, {x + kWall, y + kWall, kHeight}});
    scene.boxes.push_back({{-x, -y - kWall, 0}, {x, -y, kHeight}});
    scene.boxes.push_back({{-x, y, 0}, {x, y + kWall, kHeight}});
    scene.boxes.push_back(
        {{-x - kWall, -y - kWall, kHeight}, {x + kWall, y + kWall, kHeight + kWall}});
}

}  // namespace

Cylinder MovingThings::walkerAt(std::size_t scan) const {
    Cylinder there = walker;
    there.centre += static_cast<double>(scan) * step;
    return there;
}

WorldPlan planWalker(std::uint64_t seed) {
    WorldPlan plan;
    SeededRandom random(seed, 3);
    plan.scene.groundZ = 0.017;
    addWalls(plan.scene);
    // Shelves along the far walls, which neither the walker nor the box is near to.
    for (const double side : {1.0, -1.0}) {
        const double x = side * (kHalfLength - 0.4), y = random.uniform(-1.5, 0.5);
        plan.scene.boxes.push_back({{x - 0.2, y, 0}, {x + 0.2, y + 1.3, 1.83}});
    }

    MovingThings moving;
    // Past the sensor on one side, two metres and more before the wall.
    const double y = random.uniform(2.4, 3.0);
    const double length = kStep * (kScans - 1);
    moving.walker = {{-0.5 * length + random.uniform(-0.5, 0.5), y}, 0.24, 0, 1.76};
    moving.step = {kStep, 0};
    const Eigen::Vector2d corner(random.uniform(-1.5, 0.9), random.uniform(-2.9, -2.3));
    moving.removed = {{corner.x(), corner.y(), 0},
                      {corner.x() + 0.63, corner.y() + 0.57, 0.94}};
    moving.removalScan = kScans / 2;
    plan.moving = moving;

    plan.sensor = {1024, 128, -0.0625, 0.0625, 30, 0.01, {0.04, 0.03, 1.13}, 0.01, 0.1};
    plan.path = {{0, 0}, {0, 0}};
    plan.scans = kScans;
    plan.pointsPerScan = 1024 * 128;
    return plan;
}

}  // namespace superray
