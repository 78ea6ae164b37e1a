// SPDX-License-Identifier: BSD-3-Clause
// Agreement with liboctomap: the same cells and values, except for cells that
// a ray merely grazes (OctoMap walks with directions in single precision).

#include <gtest/gtest.h>
#include <superray/eval/scan_source.h>
#include <superray/maps/observation_rays.h>

#include <cstdio>
#include <filesystem>
#include <ostream>
#include <random>
#include <string>

#include "system/octomap_agreement.h"

namespace superray::test {
namespace {

/// Prints the rates, and asserts what must hold.
void report(const std::string& name, double resolution, UpdatePolicy policy,
            const Agreement& a) {
    const auto share = [](std::uint64_t part, std::uint64_t whole) {
        return static_cast<double>(part) / static_cast<double>(whole);
    };
    std::printf(
        "[ agreement] %-11s %-17s %.3f m: %llu scans, %llu rays; grazed: %llu of %llu visits "
        "(%.2g, %llu at the ray's end), %llu of %llu cells (%.2g); widest graze %.2g cells; "
        "cells that differ: %llu (%.2g)\n",
        toString(policy), name.c_str(), resolution, static_cast<unsigned long long>(a.scans),
        static_cast<unsigned long long>(a.rays),
        static_cast<unsigned long long>(a.grazedVisits),
        static_cast<unsigned long long>(a.visits), share(a.grazedVisits, a.visits),
        static_cast<unsigned long long>(a.endVisits),
        static_cast<unsigned long long>(a.grazedCells),
        static_cast<unsigned long long>(a.cells), share(a.grazedCells, a.cells),
        static_cast<double>(a.farthest), static_cast<unsigned long long>(a.differing),
        share(a.differing, a.cells));
    std::fflush(stdout);
    EXPECT_EQ(a.unexplained, 0u) << "a ray has a cell by a margin that the other walk lacks";
    EXPECT_EQ(a.differingNotGrazed, 0u) << "cells differ that no ray grazes";
}

constexpr UpdatePolicy kPolicies[] = {UpdatePolicy::everyRay, UpdatePolicy::oncePerScan};

// --- the measure itself ------------------------------------------------------

TEST(Grazing, depthOfRaysThroughBesideAndAlongACell) {
    const Cell<3> cell{1, 0, 0};
    const auto depth = [&](const Point<3>& from, const Point<3>& to) {
        return static_cast<double>(depthInCell(ScaledRay(from, to, 1.0), cell));
    };
    EXPECT_DOUBLE_EQ(depth({0, 0.5, 0.5}, {3, 0.5, 0.5}), 0.5);     // through the middle
    EXPECT_DOUBLE_EQ(depth({0, 0.25, 0.5}, {3, 0.25, 0.5}), 0.25);  // along a face
    EXPECT_DOUBLE_EQ(depth({0, 0, 0.5}, {3, 0, 0.5}), 0);           // on a face
    EXPECT_DOUBLE_EQ(depth({0, -0.25, 0.5}, {3, -0.25, 0.5}), -0.25);
    EXPECT_DOUBLE_EQ(depth({0, 0.5, 0.5}, {0.75, 0.5, 0.5}), -0.25);  // ends before it
    EXPECT_DOUBLE_EQ(depth({0, 0.5, 0.5}, {1.125, 0.5, 0.5}), 0.125);
    EXPECT_DOUBLE_EQ(depth({0, 1, 0.5}, {2, -1, 0.5}), 0);         // through an edge: (1, 0)
    EXPECT_DOUBLE_EQ(depth({0.5, 0.5, 0.5}, {1.5, 1.5, 0.5}), 0);  // through the edge (1, 1)
    EXPECT_NEAR(depth({0.5, 0.4, 0.5}, {1.5, 1.4, 0.5}), 0.05, 1e-15);
}

TEST(Grazing, restBehindACell) {
    const ScaledRay ray(Point<3>(0, 0.5, 0.5), Point<3>(2.25, 0.5, 0.5), 1.0);
    EXPECT_DOUBLE_EQ(static_cast<double>(lengthAfterCell(ray, {1, 0, 0})), 0.25);
    EXPECT_DOUBLE_EQ(static_cast<double>(lengthAfterCell(ray, {2, 0, 0})), 0);
}

// --- made-up scans -----------------------------------------------------------

TEST(OctomapAgreement, randomRays) {
    for (const UpdatePolicy policy : kPolicies) {
        for (const double resolution : {0.05, 0.1, 0.2}) {
            std::mt19937 random(static_cast<unsigned>(resolution * 1000));
            std::uniform_real_distribution<float> place(-3, 3), reach(-80, 80);
            AgreementCheck check(resolution, policy);
            const auto inCells = [&](auto& distribution) {
                const float x = distribution(random), y = distribution(random);
                return Eigen::Vector3f(Eigen::Vector3f(x, y, distribution(random)) *
                                       static_cast<float>(resolution));
            };
            for (int scan = 0; scan < 5; ++scan) {
                const Eigen::Vector3f origin = inCells(place);
                std::vector<Eigen::Vector3f> points;
                for (int i = 0; i < 2000; ++i) points.push_back(inCells(reach));
                check.insert(origin, points);
            }
            const Agreement result = check.finish();
            ASSERT_EQ(result.rays, 10000u);
            ASSERT_GT(result.cells, 500000u);
            report("random", resolution, policy, result);
            EXPECT_LT(result.grazedVisits, result.visits / 10000);
        }
    }
}

/// Points on quarters of cells: faces, edges, corners, axis-aligned and
/// diagonal rays, several with one end point, some of length 0.
TEST(OctomapAgreement, raysOnFacesEdgesAndCorners) {
    for (const UpdatePolicy policy : kPolicies) {
        const double resolution = 0.125;
        std::mt19937 random(21);
        std::uniform_int_distribution<int> place(-8, 8), reach(-60, 60);
        AgreementCheck check(resolution, policy);
        const auto onLattice = [&](auto& distribution) {
            const auto quarter = [&] {
                return static_cast<float>(distribution(random)) *
                       static_cast<float>(resolution) / 4;
            };
            const float x = quarter(), y = quarter(), z = quarter();
            return Eigen::Vector3f(x, y, z);
        };
        for (int scan = 0; scan < 20; ++scan) {
            const Eigen::Vector3f origin = onLattice(place);
            std::vector<Eigen::Vector3f> points{origin};
            for (int i = 1; i < 1000; ++i) points.push_back(onLattice(reach));
            check.insert(origin, points);
        }
        const Agreement result = check.finish();
        ASSERT_EQ(result.rays, 20000u);
        ASSERT_GT(result.grazedVisits, 1000u) << "the generator makes no ties";
        report("lattice", resolution, policy, result);
    }
}

// --- real scans --------------------------------------------------------------

/// Inserts the first scans of a rawlog.
void compareRecording(const std::string& path, const std::string& name, double resolution,
                      std::uint64_t scans, PoseOrigin poses) {
    for (const UpdatePolicy policy : kPolicies) {
        ScanSourceOptions options;
        options.poses = poses;
        options.maxScans = scans;
        const auto source = openScanSource(path, options);
        AgreementCheck check(resolution, policy);
        while (const auto scan = source->next()) {
            const auto returns = readReturns(*scan->observation, {});
            ASSERT_TRUE(returns);
            const mrpt::poses::CPose3D T_map_sensor =
                scan->T_map_robot + returns->sensorOnRobot;
            const auto inMap = [&](const Eigen::Vector3f& p) {
                double x, y, z;
                T_map_sensor.composePoint(p.x(), p.y(), p.z(), x, y, z);
                return Eigen::Vector3d(x, y, z).cast<float>().eval();
            };
            std::vector<Eigen::Vector3f> points;
            for (const Eigen::Vector3f& p : returns->hits) points.push_back(inMap(p));
            check.insert(inMap(Eigen::Vector3f::Zero()), points);
        }
        const Agreement result = check.finish();
        ASSERT_EQ(result.scans, scans);
        ASSERT_GT(result.rays, scans * 10000);
        report(name, resolution, policy, result);
    }
}

struct Recording {
    const char* name;
    double resolution;
    std::uint64_t scans;
};

void PrintTo(const Recording& r, std::ostream* out) {
    *out << r.scans << " scans of " << r.name << ", " << r.resolution << " m";
}

std::string nameOf(const testing::TestParamInfo<Recording>& test) {
    return std::string(test.param.name) + "_" +
           std::to_string(static_cast<int>(test.param.resolution * 1000)) + "mm";
}

class RecordedAgreement : public testing::TestWithParam<Recording> {};

TEST_P(RecordedAgreement, sharedSequence) {
    const std::string path =
        std::string(SUPERRAY_SHARED_DATA_DIR) + "/" + GetParam().name + ".rawlog";
    if (!std::filesystem::exists(path))
        GTEST_SKIP() << "NOT TESTED: no recorded sequence at " << path;
    compareRecording(path, GetParam().name, GetParam().resolution, GetParam().scans,
                     PoseOrigin::input);
}

INSTANTIATE_TEST_SUITE_P(Sequences, RecordedAgreement,
                         testing::Values(Recording{"rgbd_room", 0.05, 3},
                                         Recording{"ouster_hall", 0.1, 2},
                                         Recording{"ouster_hall", 0.2, 3},
                                         Recording{"kitti_hdl64", 0.1, 1},
                                         Recording{"kitti_hdl64", 0.2, 1}),
                         nameOf);

class PackagedAgreement : public testing::TestWithParam<Recording> {};

/// The single scans that Debian's mrpt-common ships.
TEST_P(PackagedAgreement, packagedScan) {
    const std::string path =
        std::string("/usr/share/mrpt/datasets/") + GetParam().name + ".rawlog";
    if (!std::filesystem::exists(path))
        GTEST_SKIP() << "NOT TESTED: no " << path << " (Debian package mrpt-common)";
    compareRecording(path, GetParam().name, GetParam().resolution, GetParam().scans,
                     PoseOrigin::fixed);
}

INSTANTIATE_TEST_SUITE_P(Scans, PackagedAgreement,
                         testing::Values(Recording{"tests_rgbd", 0.05, 1},
                                         Recording{"test_velodyne_VLP16", 0.1, 1}),
                         nameOf);

}  // namespace
}  // namespace superray::test
