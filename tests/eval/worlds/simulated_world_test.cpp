// SPDX-License-Identifier: BSD-3-Clause
// The simulated worlds: what is promised about scans, and the ground truth.

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <superray/eval/input_error.h>
#include <superray/eval/point_scan.h>
#include <superray/eval/seeded_random.h>
#include <superray/eval/simulated_rawlog.h>
#include <superray/eval/simulated_world.h>
#include <superray/storage/map_file_error.h>

#include <cmath>
#include <cstring>

#include "eval/temp_folder.h"

namespace superray {
namespace {

bool samePoints(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b) {
    return a.size() == b.size() &&
           std::memcmp(a.data(), b.data(), a.size() * sizeof a.front()) == 0;
}

struct Expected {
    const char* name;
    std::size_t scans, points;
    double longestRange;    // m
    double fewestLongRays;  // share of points farther than 10 m
    friend std::ostream& operator<<(std::ostream& out, const Expected& e) {
        return out << e.name;
    }
};

class Worlds : public testing::TestWithParam<Expected> {
 protected:
    SimulatedWorld world_{GetParam().name};
};

TEST_P(Worlds, scansHaveTheNumbersOfThePaper) {
    EXPECT_EQ(world_.name(), GetParam().name);
    ASSERT_EQ(world_.scanCount(), GetParam().scans);
    EXPECT_EQ(world_.pointsPerScan(), GetParam().points);
    double last = -1;
    for (std::size_t i = 0; i < world_.scanCount(); ++i) {
        const SimulatedScan scan = world_.scan(i);
        EXPECT_EQ(scan.points.size(), GetParam().points) << i;
        EXPECT_GT(scan.seconds, last);
        last = scan.seconds;
    }
}

TEST_P(Worlds, aSeedFixesEveryBitAndAnotherSeedChangesThem) {
    const SimulatedWorld same(GetParam().name), other(GetParam().name, 2);
    for (const std::size_t i : {std::size_t{7}, world_.scanCount() - 1, std::size_t{0}}) {
        EXPECT_TRUE(samePoints(world_.scan(i).points, same.scan(i).points)) << i;
        EXPECT_FALSE(samePoints(world_.scan(i).points, other.scan(i).points)) << i;
    }
}

TEST_P(Worlds, pointsLieOnSurfacesAndRaysInFreeSpace) {
    SeededRandom random(5);
    const double noise = world_.largestNoise() + 1e-4;  // points are float32
    int checked = 0, longRays = 0;
    for (std::size_t i = 0; i < world_.scanCount(); i += 8) {
        const SimulatedScan scan = world_.scan(i);
        const auto T_map_sensor = scan.T_map_robot + scan.T_robot_sensor;
        const Eigen::Vector3d origin(T_map_sensor.x(), T_map_sensor.y(), T_map_sensor.z());
        EXPECT_FALSE(world_.occupied(origin)) << i;
        for (int n = 0; n < 2000; ++n) {
            const auto index = static_cast<std::size_t>(
                random.uniform() * static_cast<double>(scan.points.size()));
            const Eigen::Vector3f& p = scan.points[index];
            Eigen::Vector3d end;
            T_map_sensor.composePoint(p.x(), p.y(), p.z(), end.x(), end.y(), end.z());
            const Eigen::Vector3d ray = end - origin;
            const double range = ray.norm();
            longRays += range > 10;
            const auto truth = world_.castRay(origin, ray);
            ASSERT_TRUE(truth.has_value()) << i << " " << index;
            ASSERT_NEAR(*truth, range, noise) << i << " " << index;
            ASSERT_LE(range, GetParam().longestRange + noise);
            // The surface parts free space from solid, by the truth's own test.
            const Eigen::Vector3d unit = ray / range;
            EXPECT_TRUE(world_.occupied(origin + unit * (*truth + 1e-7))) << i << " " << index;
            EXPECT_FALSE(world_.occupied(origin + unit * (*truth - 1e-7))) << i << " " << index;
            for (double t = 0; t < *truth - 1e-6; t += 0.25)
                ASSERT_FALSE(world_.occupied(origin + unit * t)) << i << " " << index;
            ++checked;
        }
    }
    EXPECT_GE(checked, 16000);
    EXPECT_GE(longRays, GetParam().fewestLongRays * checked);
}

INSTANTIATE_TEST_SUITE_P(All, Worlds,
                         testing::Values(Expected{"indoor", 66, 89446, 30, 0.003},
                                         Expected{"outdoor", 81, 247817, 80, 0.2}),
                         [](const auto& p) { return std::string(p.param.name); });

TEST(SimulatedWorld, refusesUnknownNames) {
    EXPECT_FALSE(SimulatedWorld::isName("moon"));
    EXPECT_NE(test::messageOf<InputError>([] { SimulatedWorld("moon"); }).find("'moon'"),
              std::string::npos);
}

TEST(SimulatedWorld, isASourceOfPointsInTheMapFrame) {
    PointScanRequest request;
    request.data = "indoor";
    request.source.maxScans = 2;
    std::uint64_t told = 0;
    const PointScans scans =
        loadPointScans(request, [&](std::uint64_t done, std::uint64_t total) {
            EXPECT_EQ(total, 2u);
            told = done;
        });
    EXPECT_EQ(told, 2u);
    EXPECT_EQ(scans.name, "indoor");
    ASSERT_EQ(scans.scans.size(), 2u);
    EXPECT_EQ(scans.points, 2u * 89446);
    const SimulatedWorld world("indoor");
    int beside = 0;
    for (const PointScan& scan : scans.scans) {
        EXPECT_FALSE(world.occupied(scan.origin.cast<double>()));
        for (const Eigen::Vector3f& p : scan.points) {
            const Eigen::Vector3d ray = (p - scan.origin).cast<double>();
            const auto truth = world.castRay(scan.origin.cast<double>(), ray);
            // Near edges, rounding to float may pass by the surface that was hit.
            beside += !truth || std::abs(*truth - ray.norm()) > world.largestNoise() + 1e-3;
            EXPECT_TRUE(scans.bounds.contains(p));
        }
    }
    EXPECT_LT(beside, 100);
}

TEST(SimulatedWorld, readsBackFromItsRecording) {
    test::TempFolder folder;
    const std::string path = folder / "hall.rawlog";
    const SimulatedWorld world("indoor", 4);
    writeSimulatedRawlog(world, 5, path);
    PointScanRequest simulated, recorded, withPoses;
    simulated.data = "indoor";
    simulated.worldSeed = 4;
    simulated.source.maxScans = 5;
    recorded.data = withPoses.data = path;
    withPoses.source.poses = PoseOrigin::file;
    withPoses.source.posesFile = folder / "hall.tum";
    const PointScans expected = loadPointScans(simulated);
    ASSERT_EQ(expected.scans.size(), 5u);
    for (const auto& request : {recorded, withPoses}) {
        const PointScans read = loadPointScans(request);
        ASSERT_EQ(read.scans.size(), 5u);
        EXPECT_EQ(read.name, "hall");
        for (std::size_t i = 0; i < 5; ++i) {
            EXPECT_TRUE(read.scans[i].origin == expected.scans[i].origin);
            EXPECT_TRUE(samePoints(read.scans[i].points, expected.scans[i].points)) << i;
        }
    }
    // What the sensor saw, bit for bit.
    const auto source = openScanSource(path);
    EXPECT_EQ(source->total(), 5u);
    const auto first = source->next();
    ASSERT_TRUE(first.has_value());
    const auto& cloud =
        dynamic_cast<const mrpt::obs::CObservationPointCloud&>(*first->observation);
    EXPECT_FALSE(cloud.sensorPose == mrpt::poses::CPose3D());
    EXPECT_EQ(cloud.pointcloud->size(), world.pointsPerScan());
    EXPECT_NE(test::messageOf<MapFileError>([&] {
                  writeSimulatedRawlog(world, 1, folder / "none/a.rawlog");
              }).find("/none"),
              std::string::npos);
}

// The numbers themselves: a change of the generator would change every world.
TEST(SeededRandom, isTheSameEverywhere) {
    SeededRandom a(1, 2);
    EXPECT_EQ(a.uniform(), SeededRandom(1, 2).uniform());
    EXPECT_NE(SeededRandom(1, 2).uniform(), SeededRandom(1, 3).uniform());
    EXPECT_NE(SeededRandom(1, 2).uniform(), SeededRandom(2, 2).uniform());
    SeededRandom random(3);
    double sum = 0, squares = 0, largest = 0;
    constexpr int kDraws = 200000;
    for (int i = 0; i < kDraws; ++i) {
        const double x = random.bell(2.0);
        sum += x;
        squares += x * x;
        largest = std::max(largest, std::abs(x));
    }
    EXPECT_NEAR(sum / kDraws, 0, 0.02);
    EXPECT_NEAR(squares / kDraws, 4, 0.05);
    EXPECT_LE(largest, 2 * SeededRandom::kBellBound);
    EXPECT_GT(largest, 5);
}

}  // namespace
}  // namespace superray
