// SPDX-License-Identifier: BSD-3-Clause
// The engines of the benchmark: found by name, and each makes the map it should.

#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <superray/eval/bench_engine.h>
#include <superray/eval/input_error.h>
#include <superray/maps/mrpt_compat.h>

#include <set>

#include "eval/engines/bench_scans.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;

BenchEngineOptions optionsFor(const PointScans& scans, UpdatePolicy policy) {
    BenchEngineOptions options;
    options.resolution = 0.2;
    options.policy = policy;
    options.bounds = scans.bounds;
    return options;
}

void insertAll(BenchEngine& engine, const PointScans& scans) {
    for (const PointScan& scan : scans.scans) {
        engine.prepare(scan);
        engine.insert();
    }
}

TEST(BenchEngines, areListedByName) {
    std::set<std::string> names;
    for (const auto& engine : benchEngines()) {
        EXPECT_TRUE(names.insert(engine.name).second) << engine.name;
        EXPECT_FALSE(engine.description.empty());
        EXPECT_EQ(&benchEngine(engine.name), &engine);
    }
    for (const char* name :
         {"octomap", "octomap-rays", "mrpt-octomap", "mrpt-grid3d", "grid", "grid-perRay",
          "grid-superRays", "grid-culling", "grid-full", "grid-reference", "octree",
          "octree-perRay", "octree-superRays", "octree-culling", "octree-full",
          "octree-reference", "grid-copies", "octree-copies"})
        EXPECT_EQ(names.count(name), 1u) << name;
    const auto message = messageOf<InputError>([] { benchEngine("octo"); });
    EXPECT_NE(message.find("'octo'"), std::string::npos);
    EXPECT_NE(message.find("mrpt-grid3d"), std::string::npos);
    EXPECT_THROW(addBenchEngine(benchEngine("grid")), std::invalid_argument);
}

TEST(BenchEngines, voxelMapIsListedWhereMrptHasIt) {
#if SUPERRAY_HAS_MRPT_VOXEL_MAP
    EXPECT_EQ(benchEngine("mrpt-voxelmap").ownPolicy, "rayByRay");
#else
    const auto message = messageOf<InputError>([] { benchEngine("mrpt-voxelmap"); });
    EXPECT_NE(message.find("needs MRPT >= 2.11"), std::string::npos) << message;
#endif
}

/// The peers' maps are what one makes of the same points by hand.
TEST(BenchEngines, octomapIsLiboctomap) {
    TempFolder folder;
    const PointScans scans = smallScans(folder / "");
    ASSERT_EQ(scans.scans.size(), 3u);
    const auto engine = benchEngine("octomap").make(optionsFor(scans, UpdatePolicy::everyRay));
    insertAll(*engine, scans);
    octomap::OcTree tree(0.2);
    tree.setProbHit(0.7);
    tree.setProbMiss(0.4);
    tree.setClampingThresMin(0.1192);
    tree.setClampingThresMax(0.971);
    for (const PointScan& scan : scans.scans) {
        octomap::Pointcloud cloud;
        for (const auto& p : scan.points) cloud.push_back(p.x(), p.y(), p.z());
        tree.insertPointCloud(cloud, {scan.origin.x(), scan.origin.y(), scan.origin.z()});
    }
    EXPECT_EQ(engine->mapBytes(), tree.memoryUsage());
    int compared = 0;
    for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf, ++compared) {
        const auto c = leaf.getCoordinate();
        const auto p = engine->occupancy({c.x(), c.y(), c.z()});
        ASSERT_TRUE(p.has_value());
        EXPECT_EQ(*p, leaf->getOccupancy());
    }
    EXPECT_GT(compared, 1000);
    EXPECT_FALSE(engine->occupancy({100, 100, 100}).has_value());
}

/// Every engine agrees with octomap about most cells: points got where they
/// belong. (MRPT's approximate grid less so.)
TEST(BenchEngines, allMapTheSamePlace) {
    TempFolder folder;
    const PointScans scans = smallScans(folder / "");
    const auto options = optionsFor(scans, UpdatePolicy::oncePerScan);
    const auto octomap = benchEngine("octomap").make(options);
    insertAll(*octomap, scans);
    int engines = 0;
    for (const auto& info : benchEngines()) {
        const auto engine = info.make(options);
        insertAll(*engine, scans);
        EXPECT_GT(engine->mapBytes(), 1000u) << info.name;
        int known = 0, agreed = 0;
        for (float x = -6; x < 6; x += 0.2f)
            for (float y = -6; y < 6; y += 0.2f)
                for (float z = -5; z < 5; z += 0.2f) {
                    const Eigen::Vector3f p(x + 0.05f, y + 0.05f, z + 0.05f);
                    const auto a = octomap->occupancy(p), b = engine->occupancy(p);
                    if (!a || !b) continue;
                    ++known;
                    agreed += (*a > 0.5) == (*b > 0.5);
                }
        EXPECT_GT(known, 3000) << info.name;
        EXPECT_GT(agreed, (info.name == "mrpt-grid3d" ? 0.9 : 0.97) * known) << info.name;
        if (info.exact) {
            EXPECT_EQ(engine->digest(), octomap->digest()) << info.name;
            EXPECT_EQ(agreed, known) << info.name;
        }
        ++engines;
    }
    EXPECT_GE(engines, 18);
}

TEST(BenchEngines, copiesAreIndependentMaps) {
    TempFolder folder;
    const PointScans scans = smallScans(folder / "");
    auto options = optionsFor(scans, UpdatePolicy::everyRay);
    for (const std::string name : {"grid", "octree"}) {
        const auto one = benchEngine(name).make(options);
        options.threads = 3;
        const auto three = benchEngine(name + "-copies").make(options);
        options.threads = 1;
        insertAll(*one, scans);
        insertAll(*three, scans);
        EXPECT_EQ(three->digest(), one->digest());
        EXPECT_EQ(three->mapBytes(), 3 * one->mapBytes());
        EXPECT_EQ(three->work().rays, one->work().rays);
    }
}

TEST(BenchEngines, reportTheirWork) {
    TempFolder folder;
    const PointScans scans = smallScans(folder / "");
    for (const char* name : {"grid", "octree-full", "grid-perRay"}) {
        const auto engine = benchEngine(name).make(optionsFor(scans, UpdatePolicy::everyRay));
        BenchWork sum;
        for (const PointScan& scan : scans.scans) {
            engine->prepare(scan);
            engine->insert();
            sum += engine->work();
            EXPECT_NE(engine->saturation(), nullptr);
        }
        EXPECT_EQ(sum.rays, 900u) << name;
        EXPECT_LE(sum.superRays, 900u) << name;
        EXPECT_GT(sum.traversedCells, 900u) << name;
        EXPECT_GT(sum.toRaysSeconds, 0) << name;
        EXPECT_GT(sum.traversalSeconds, 0) << name;
        EXPECT_GT(sum.applySeconds, 0) << name;
    }
}

}  // namespace
}  // namespace superray
