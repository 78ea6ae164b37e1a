// SPDX-License-Identifier: BSD-3-Clause
// Errors of trajectories whose answers can be worked out by hand.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>
#include <superray/slam/trajectory_error.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

namespace superray {
namespace {

using mrpt::poses::CPose3D;

mrpt::Clock::time_point at(double seconds) {
    return mrpt::Clock::fromDouble(1e9 + seconds);
}

template <class PoseAt>
Trajectory trajectory(int count, PoseAt poseAt) {
    Trajectory t;
    for (int i = 0; i < count; ++i) t.add(at(i), poseAt(i));
    return t;
}

Trajectory straight(double step) {
    return trajectory(101, [=](int i) { return CPose3D(step * i, 0, 0, 0, 0, 0); });
}

/// Smooth, in all six coordinates.
CPose3D winding(int i) {
    const double s = 0.1 * i;
    return {5 * std::sin(s), 4 * s, std::cos(2 * s), 0.7 * s, 0.2 * std::sin(s), 0.1 * s};
}

TEST(TrajectoryError, RigidMotionIsNoError) {
    const auto truth = trajectory(60, winding);
    const CPose3D moved(10, -20, 3, 2.5, 0.4, -0.7);
    const auto estimate = trajectory(60, [&](int i) { return moved + winding(i); });
    const auto e = compareTrajectories(estimate, truth);
    EXPECT_EQ(e.poses, 60u);
    EXPECT_EQ(e.unmatched, 0u);
    EXPECT_LT(e.absolute.maximum, 1e-9);
    EXPECT_LT(e.absoluteRotation.maximum, 1e-7);
    EXPECT_LT(e.relative.maximum, 1e-9);
    EXPECT_LT(e.relativeRotation.maximum, 1e-7);
    EXPECT_LT(e.drift(), 1e-9);
    ASSERT_EQ(e.segments.size(), 3u);
    for (const auto& s : e.segments) {
        EXPECT_GT(s.segments, 0u);
        EXPECT_LT(s.translation, 1e-9);
    }
}

TEST(TrajectoryError, ScaleErrorOfAStraightLine) {
    TrajectoryErrorOptions options;
    options.segmentLengths = {10, 50, 200};
    const auto e = compareTrajectories(straight(1.01), straight(1), options);
    EXPECT_NEAR(e.pathLength, 100, 1e-9);
    EXPECT_NEAR(e.drift(), 0.01, 1e-9);
    EXPECT_NEAR(e.endTranslation, 1.0, 1e-9);
    EXPECT_NEAR(e.relative.rmse, 0.01, 1e-9);
    // Position i is 0.01 (i - 50) off; mean of (i - 50)^2 over 101 values = 850.
    EXPECT_NEAR(e.absolute.rmse, 0.01 * std::sqrt(850.0), 1e-9);
    EXPECT_NEAR(e.absolute.maximum, 0.5, 1e-9);
    EXPECT_NEAR(e.absolute.mean, 0.01 * 2550 / 101, 1e-9);
    EXPECT_NEAR(e.absolute.median, 0.25, 1e-9);
    ASSERT_EQ(e.segments.size(), 3u);
    EXPECT_EQ(e.segments[0].segments, 91u);
    EXPECT_NEAR(e.segments[0].translation, 0.01, 1e-9);
    EXPECT_EQ(e.segments[1].segments, 51u);
    EXPECT_NEAR(e.segments[1].translation, 0.01, 1e-9);
    EXPECT_EQ(e.segments[2].segments, 0u) << "longer than the path";
}

TEST(TrajectoryError, ConstantTurnOfEveryMotion) {
    const double turn = 0.002;
    // Dead reckoning along a line with a turn too many in every step.
    const CPose3D step(1, 0, 0, turn, 0, 0);
    Trajectory estimate;
    CPose3D pose;
    for (int i = 0; i <= 100; ++i, pose = pose + step) estimate.add(at(i), pose);
    TrajectoryErrorOptions options;
    options.segmentLengths = {20};
    const auto e = compareTrajectories(estimate, straight(1), options);
    EXPECT_NEAR(e.relativeRotation.rmse, turn, 1e-9);
    EXPECT_NEAR(e.relative.rmse, 0, 1e-9);
    EXPECT_NEAR(e.endRotation, 100 * turn, 1e-9);
    EXPECT_NEAR(e.segments.at(0).rotation, turn, 1e-9);
    options.relativeStep = 10;
    EXPECT_NEAR(compareTrajectories(estimate, straight(1), options).relativeRotation.rmse,
                10 * turn, 1e-9);
}

TEST(TrajectoryError, NoiseOfKnownSize) {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 0.05);
    int made = 0;
    const auto truth = trajectory(3000, winding);
    const auto estimate = trajectory(3000, [&](int i) {
        ++made;
        const CPose3D p = winding(i);
        return CPose3D(p.x() + noise(random), p.y() + noise(random), p.z() + noise(random),
                       p.yaw(), p.pitch(), p.roll());
    });
    ASSERT_EQ(made, 3000);
    const auto e = compareTrajectories(estimate, truth);
    EXPECT_NEAR(e.absolute.rmse, 0.05 * std::sqrt(3.0), 0.003);
    EXPECT_NEAR(e.relative.rmse, 0.05 * std::sqrt(6.0), 0.005);
    EXPECT_NEAR(e.relativeRotation.rmse, 0, 1e-7);
}

TEST(TrajectoryError, TimesAreInterpolatedAndCounted) {
    const auto truth = straight(1);
    Trajectory estimate;
    for (int i = 0; i < 10; ++i) estimate.add(at(i + 0.5), CPose3D(i + 0.5, 0, 0, 0, 0, 0));
    estimate.add(at(500), CPose3D());
    const auto e = compareTrajectories(estimate, truth);
    EXPECT_EQ(e.poses, 10u);
    EXPECT_EQ(e.unmatched, 1u);
    EXPECT_LT(e.absolute.maximum, 1e-5);
    EXPECT_NE(describe(e).find("1 estimates outside the true times"), std::string::npos);
}

TEST(TrajectoryError, DefaultSegmentsAreThoseOfKittiOnLongPaths) {
    const auto e = compareTrajectories(straight(4.5), straight(4.5));  // 450 m
    ASSERT_EQ(e.segments.size(), 4u);
    EXPECT_EQ(e.segments.front().length, 100);
    EXPECT_EQ(e.segments.back().length, 400);
}

TEST(TrajectoryError, BadInputIsRefused) {
    Trajectory two;
    two.add(at(0), CPose3D());
    two.add(at(1), CPose3D());
    EXPECT_THROW(compareTrajectories(two, straight(1)), InputError);
    TrajectoryErrorOptions options;
    options.segmentLengths = {-1};
    EXPECT_THROW(compareTrajectories(straight(1), straight(1), options), InputError);
    options = {};
    options.relativeStep = 0;
    EXPECT_THROW(compareTrajectories(straight(1), straight(1), options), InputError);
}

TEST(TrajectoryError, JsonHasTheNumbers) {
    const auto e = compareTrajectories(straight(1.01), straight(1));
    const auto json = nlohmann::json::parse(describeAsJson(e));
    EXPECT_EQ(json["poses"], 101);
    EXPECT_NEAR(json["drift"].get<double>(), 0.01, 1e-9);
    EXPECT_NEAR(json["ate"]["rmse"].get<double>(), e.absolute.rmse, 1e-12);
    EXPECT_EQ(json["segments"].size(), 3u);
}

}  // namespace
}  // namespace superray
