// SPDX-License-Identifier: BSD-3-Clause
// A scan of a synthetic room finds its pose again.

#include <gtest/gtest.h>
#include <superray/slam/scan_registration.h>

#include <random>

#include "slam/synthetic_room.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

TRegistrationOptions roomOptions() {
    TRegistrationOptions o;
    o.resolutions = "0.6, 0.3";
    o.pointSpacing = 0.15;
    return o;
}

class Room : public ::testing::Test {
 protected:
    explicit Room(const TRegistrationOptions& options = roomOptions())
        : registration_(options, TSlamOptions().icp), options_(options) {
        for (int i = 0; i < 4; ++i)
            registration_.insert(test::returnsOf(test::roomScan(test::roomPose(4 * i), i, i)),
                                 test::roomPose(4 * i));
        scan_ = thinOut(test::returnsOf(test::roomScan(truth_, 9, 99)), options_);
    }

    static double angleBetween(const CPose3D& a, const CPose3D& b) {
        const Eigen::Matrix3d R = (b - a).getRotationMatrix().asEigen();
        return std::acos(std::clamp((R.trace() - 1) / 2, -1.0, 1.0)) * 180 / M_PI;
    }

    ScanRegistration registration_;
    TRegistrationOptions options_;
    CPose3D truth_ = test::roomPose(9);
    RegistrationPoints scan_;
};

TEST_F(Room, PoseIsFoundFromPerturbedStarts) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> shift(-0.15, 0.15), turn(-0.08, 0.08);
    int trials = 0;
    for (; trials < 20; ++trials) {
        const CPose3D start = truth_ + CPose3D(shift(random), shift(random), shift(random),
                                               turn(random), turn(random), turn(random));
        const auto found = registration_.align(scan_, {start});
        EXPECT_LT(found.T_map_robot.distanceTo(truth_), 0.01);
        EXPECT_LT(angleBetween(found.T_map_robot, truth_), 0.15);
        EXPECT_GT(found.goodness, 0.6);
        EXPECT_LT(found.residual, 0.03);
        EXPECT_GT(found.icpIterations, 0u);
        EXPECT_GT(found.refinementSteps, 0u);
    }
    ASSERT_EQ(trials, 20);
}

TEST_F(Room, ThinnedPointsAreMeansInTheRobotFrame) {
    const auto returns = test::returnsOf(test::roomScan(truth_, 9, 99));
    EXPECT_LT(scan_.points.size(), returns.hits.size() / 2);
    ASSERT_GT(scan_.points.size(), 500u);
    ASSERT_EQ(scan_.weights.size(), scan_.points.size());
    for (std::size_t i = 0; i < scan_.points.size(); ++i) EXPECT_EQ(scan_.weights[i], 1);
    // In the robot frame the floor is below the robot, not below the lidar.
    int floor = 0;
    for (const auto& p : scan_.points) {
        double x, y, z;
        truth_.composePoint(p.x(), p.y(), p.z(), x, y, z);
        floor += std::abs(z + 0.01) < 0.03;
    }
    EXPECT_GT(floor, 100);

    auto near = options_;
    near.maxRange = 2;
    near.rangeNoiseExponent = 2;
    const auto some = thinOut(returns, near);
    EXPECT_LT(some.points.size(), scan_.points.size());
    ASSERT_GT(some.points.size(), 50u);
    for (std::size_t i = 0; i < some.points.size(); ++i) {
        const Eigen::Vector3d sensor(test::lidarOnRobot().x(), test::lidarOnRobot().y(),
                                     test::lidarOnRobot().z());
        const double range = (some.points[i] - sensor).norm();
        EXPECT_LT(range, 2.01);
        EXPECT_NEAR(some.weights[i] * std::pow(range, 4), 1, 1e-9);
    }
}

TEST_F(Room, NothingInCommonHasNoGoodness) {
    const auto found = registration_.align(scan_, {CPose3D(500, 0, 0, 0, 0, 0)});
    EXPECT_EQ(found.goodness, 0);
    EXPECT_NEAR(found.T_map_robot.x(), 500, 1e-3) << "the start pose stays";
}

TRegistrationOptions icpAlone() {
    auto o = roomOptions();
    o.refinementSteps = 0;
    return o;
}
class RoomIcpAlone : public Room {
 protected:
    RoomIcpAlone() : Room(icpAlone()) {}
};

TEST_F(RoomIcpAlone, CicpAgainstTheMapGoesTheRightWay) {
    const CPose3D start = truth_ + CPose3D(0.1, -0.1, 0.05, 0.04, 0, 0);
    const auto found = registration_.align(scan_, {start});
    EXPECT_EQ(found.refinementSteps, 0u);
    EXPECT_GT(found.goodness, 0.8);
    EXPECT_LT(found.T_map_robot.distanceTo(truth_), 0.5 * start.distanceTo(truth_));
    EXPECT_LT(angleBetween(found.T_map_robot, truth_), 0.5 * angleBetween(start, truth_));
}

TRegistrationOptions withYawSearch() {
    auto o = roomOptions();
    o.yawSearch = 45;
    o.yawStep = 5;
    return o;
}
class RoomTurned : public Room {
 protected:
    explicit RoomTurned(const TRegistrationOptions& o = withYawSearch()) : Room(o) {}
};

TEST_F(RoomTurned, YawSearchFindsLargeTurns) {
    int trials = 0;
    for (const double degrees : {-40.0, -25.0, 25.0, 40.0}) {
        const CPose3D start = truth_ + CPose3D(0, 0, 0, degrees * M_PI / 180, 0, 0);
        const auto found = registration_.align(scan_, {start});
        EXPECT_LT(found.T_map_robot.distanceTo(truth_), 0.01) << degrees;
        EXPECT_LT(angleBetween(found.T_map_robot, truth_), 0.15) << degrees;
        ++trials;
    }
    ASSERT_EQ(trials, 4);
    const ScanRegistration without(roomOptions(), TSlamOptions().icp);
    EXPECT_TRUE(without.empty());
}

TEST_F(Room, LargeTurnsNeedTheSearch) {
    const auto found =
        registration_.align(scan_, {truth_ + CPose3D(0, 0, 0, 40 * M_PI / 180, 0, 0)});
    EXPECT_GT(angleBetween(found.T_map_robot, truth_), 5);
}

}  // namespace
}  // namespace superray
