// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/seeded_random.h>

#include "worlds/world_plans.h"

namespace superray {
namespace {

// The storey [m]. Walls do not lie on multiples of usual cell edges.
constexpr double kHeight = 2.73;
constexpr double kWall = 0.16;
constexpr double kHalfCorridor = 1.23;
constexpr double kRoomWidth = 5.87, kRoomDepth = 5.31;
constexpr int kRoomsPerSide = 7;
constexpr double kHalfDoor = 0.52, kDoorHeight = 2.07;
constexpr double kLength = kRoomsPerSide * (kRoomWidth + kWall) - kWall;

double roomStart(int room) {
    return room * (kRoomWidth + kWall);
}
double doorAt(int room) {
    return roomStart(room) + 0.5 * kRoomWidth;
}

/// A box given by any two corners.
void addBox(SolidScene& scene, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    scene.boxes.push_back({a.cwiseMin(b), a.cwiseMax(b)});
}

/// Walls, a desk, a shelf, a locker and a bin; `side` is +1 or -1 (y).
void addRoom(SolidScene& scene, int room, double side, SeededRandom& random) {
    const double x0 = roomStart(room), x1 = x0 + kRoomWidth;
    const double y0 = side * kHalfCorridor, y1 = y0 + side * kWall, y2 = y1 + side * kRoomDepth;
    const double door = doorAt(room);
    // The wall towards the corridor, with its door.
    addBox(scene, {x0 - kWall, y0, 0}, {door - kHalfDoor, y1, kHeight});
    addBox(scene, {door + kHalfDoor, y0, 0}, {x1, y1, kHeight});
    addBox(scene, {door - kHalfDoor, y0, kDoorHeight}, {door + kHalfDoor, y1, kHeight});
    // Back wall; the wall to the next room.
    addBox(scene, {x0 - kWall, y2, 0}, {x1 + kWall, y2 + side * kWall, kHeight});
    addBox(scene, {x1, y0, 0}, {x1 + kWall, y2, kHeight});

    const double deskX = x0 + random.uniform(0.3, 1.2);
    const double deskY = y2 - side * random.uniform(0.1, 0.5);
    addBox(scene, {deskX, deskY, 0.68}, {deskX + 1.58, deskY - side * 0.79, 0.73});
    for (const double leg : {0.05, 1.49})
        addBox(scene, {deskX + leg, deskY - side * 0.05, 0},
               {deskX + leg + 0.05, deskY - side * 0.70, 0.68});
    const double shelfY = y1 + side * random.uniform(1.0, 2.5);
    addBox(scene, {x1 - 0.37, shelfY, 0}, {x1, shelfY + side * 1.2, 1.93});
    const double lockerX = x0 + random.uniform(3.4, 4.4);
    addBox(scene, {lockerX, y2, 0}, {lockerX + 0.8, y2 - side * 0.45, 1.2});
    scene.cylinders.push_back({{x0 + random.uniform(0.3, 1.5), y1 + side * 0.4}, 0.17, 0, 0.5});
}

}  // namespace

WorldPlan planIndoor(std::uint64_t seed) {
    WorldPlan plan;
    SeededRandom random(seed, 1);
    SolidScene& scene = plan.scene;
    const double yEnd = kHalfCorridor + kRoomDepth + 2 * kWall;
    addBox(scene, {-1, -yEnd, kHeight}, {kLength + 1, yEnd, kHeight + 0.3});  // ceiling
    addBox(scene, {-kWall, -yEnd, 0}, {0, yEnd, kHeight});
    addBox(scene, {kLength, -yEnd, 0}, {kLength + kWall, yEnd, kHeight});
    for (const double side : {1.0, -1.0})
        for (int room = 0; room < kRoomsPerSide; ++room) addRoom(scene, room, side, random);
    scene.groundZ = 0.013;

    plan.sensor = {704, 128, -0.215, 0.215, 30, 0.008, {0.11, 0, 1.17}, 0.02, 0.5};
    // Along the corridor, with a look into the middle of every other room.
    plan.path = {{0.9, 0}};
    for (int room = 0; room < kRoomsPerSide; ++room) {
        const double side = room % 2 == 0 ? 1 : -1;
        const double x = doorAt(room);
        plan.path.push_back({x, 0});
        plan.path.push_back({x, side * (kHalfCorridor + 2.6)});
        plan.path.push_back({x, 0});
    }
    plan.path.push_back({kLength - 0.9, 0});
    plan.scans = 66;
    plan.pointsPerScan = 89446;
    return plan;
}

}  // namespace superray
