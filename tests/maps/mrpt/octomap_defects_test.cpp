// SPDX-License-Identifier: BSD-3-Clause
// What goes wrong with MRPT's own COctoMap (2.5.8), each beside our maps, where it
// does not. A failure of "stock" here means that MRPT has repaired something.

#include <mrpt/maps/COctoMap.h>
#include <mrpt/serialization/CArchive.h>
#include <octomap/OcTree.h>
#include <superray/maps/CSuperRayOctoMap.h>

#include <iostream>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::maps::COctoMap;
using mrpt::poses::CPose3D;

constexpr double kResolution = 0.1;

/// Each of our 3D maps, empty.
std::vector<mrpt::maps::CMetricMap::Ptr> ourMaps() {
    std::vector<mrpt::maps::CMetricMap::Ptr> maps;
    for (const std::string name : {"CSuperRayGridMap3D", "CSuperRayOctoMap"}) {
        maps.push_back(createMap(name));
        test::interfaceOf(*maps.back()).setResolution(kResolution);
    }
    return maps;
}

double stockOccupancy(const COctoMap& map, const mrpt::math::TPoint3D& p) {
    double occupancy = -1;  // unknown
    map.getPointOccupancy(static_cast<float>(p.x), static_cast<float>(p.y),
                          static_cast<float>(p.z), occupancy);
    return occupancy;
}
double ourOccupancy(const mrpt::maps::CMetricMap& map, const mrpt::math::TPoint3D& p) {
    const auto& storage = dynamic_cast<const CSuperRayMapBase<3>&>(map).storage();
    const auto value = storage.logOdds(storage.geometry().cellOf({p.x, p.y, p.z}));
    return value ? probabilityOf(*value) : -1;
}

/// A point straight ahead of a sensor that looks to the left of the robot.
const CPose3D kSensorPose(0.5, 0, 1, M_PI / 2, 0, 0);
const mrpt::math::TPoint3D kInSensor(2.05, 0.05, 0.05);
mrpt::math::TPoint3D inRobotFrame() {
    return kSensorPose.composePoint(kInSensor);
}

void expectSensorPoseMatters(const mrpt::obs::CObservation& scan) {
    COctoMap stock(kResolution);
    stock.insertObservation(scan);
    EXPECT_LT(stockOccupancy(stock, inRobotFrame()), 0.5) << "stock: repaired";
    EXPECT_GT(stockOccupancy(stock, kInSensor), 0.5) << "stock: repaired";
    for (const auto& map : ourMaps()) {
        ASSERT_TRUE(map->insertObservation(scan));
        EXPECT_GT(ourOccupancy(*map, inRobotFrame()), 0.5);
        EXPECT_EQ(ourOccupancy(*map, kInSensor), -1);
    }
}

mrpt::obs::CObservationPointCloud cloudOf(const mrpt::math::TPoint3D& p) {
    mrpt::obs::CObservationPointCloud scan;
    scan.pointcloud = mrpt::maps::CSimplePointsMap::Create();
    scan.pointcloud->insertPoint(static_cast<float>(p.x), static_cast<float>(p.y),
                                 static_cast<float>(p.z));
    return scan;
}

TEST(OctomapDefects, SensorPoseOfPointClouds) {
    auto scan = cloudOf(kInSensor);
    scan.sensorPose = kSensorPose;
    expectSensorPoseMatters(scan);
}

TEST(OctomapDefects, SensorPoseOf3DScans) {
    mrpt::obs::CObservation3DRangeScan scan;
    scan.hasPoints3D = true;
    scan.points3D_x = {static_cast<float>(kInSensor.x)};
    scan.points3D_y = {static_cast<float>(kInSensor.y)};
    scan.points3D_z = {static_cast<float>(kInSensor.z)};
    scan.sensorPose = kSensorPose;
    expectSensorPoseMatters(scan);
}

TEST(OctomapDefects, SensorPoseOfVelodyneClouds) {
    mrpt::obs::CObservationVelodyneScan scan;
    scan.point_cloud.x = {static_cast<float>(kInSensor.x)};
    scan.point_cloud.y = {static_cast<float>(kInSensor.y)};
    scan.point_cloud.z = {static_cast<float>(kInSensor.z)};
    scan.sensorPose = kSensorPose;
    expectSensorPoseMatters(scan);
}

TEST(OctomapDefects, RangeImagesAreIgnored) {
    mrpt::obs::CObservation3DRangeScan scan;
    scan.hasRangeImage = true;
    scan.range_is_depth = true;
    scan.rangeUnits = 0.001f;
    scan.cameraParams.ncols = 16;
    scan.cameraParams.nrows = 12;
    scan.cameraParams.setIntrinsicParamsFromValues(16, 16, 8, 6);
    scan.rangeImage.resize(12, 16);
    scan.rangeImage.fill(2000);
    COctoMap stock(kResolution);
    stock.insertObservation(scan);
    EXPECT_EQ(stock.size(), 0u) << "stock: repaired";
    for (const auto& map : ourMaps()) {
        ASSERT_TRUE(map->insertObservation(scan));
        EXPECT_GT(test::interfaceOf(*map).cellTotals().occupied, 50u);
    }
}

TEST(OctomapDefects, RawVelodynePacketsAreIgnored) {
    const auto file = test::mrptDataset("test_velodyne_VLP16.rawlog");
    SUPERRAY_SKIP_WITHOUT(file);
    const auto scan = test::readScans(file, 1).at(0).scan;
    COctoMap stock(kResolution);
    stock.insertObservation(*scan);
    EXPECT_EQ(stock.size(), 0u) << "stock: repaired";
    for (const auto& map : ourMaps()) {
        ASSERT_TRUE(map->insertObservation(*scan));
        EXPECT_EQ(test::interfaceOf(*map).lastInsertion().rays, 22591u);
        EXPECT_GT(test::interfaceOf(*map).cellTotals().occupied, 1000u);
    }
}

/// Often enough that what is free saturates and can be merged.
mrpt::obs::CObservationPointCloud denseWall() {
    mrpt::obs::CObservationPointCloud scan;
    scan.pointcloud = mrpt::maps::CSimplePointsMap::Create();
    for (int y = -60; y < 60; ++y)
        for (int z = -60; z < 60; ++z)
            scan.pointcloud->insertPoint(3.05f, 0.02f * static_cast<float>(y),
                                         0.02f * static_cast<float>(z));
    return scan;
}

TEST(OctomapDefects, NothingIsPruned) {
    const auto scan = denseWall();
    COctoMap stock(kResolution);
    CSuperRayOctoMap ours(kResolution);
    for (int i = 0; i < 12; ++i) {
        ASSERT_TRUE(stock.insertObservation(scan));
        ASSERT_TRUE(ours.insertObservation(scan));
    }
    // The same cells as a pruned tree.
    octomap::OcTree pruned(ours.octree());
    pruned.prune();
    EXPECT_EQ(ours.octree().size(), pruned.size());
    EXPECT_GT(stock.size(), ours.octree().size() * 5 / 4) << "stock: repaired";
    std::cout << "tree nodes: stock " << stock.size() << ", ours " << ours.octree().size()
              << "\n";
}

template <class Map>
void serializeAndReadBack(const Map& map, Map& copy) {
    std::vector<std::uint8_t> bytes;
    mrpt::serialization::ObjectToOctetVector(&map, bytes);
    mrpt::serialization::CSerializable::Ptr object;
    mrpt::serialization::OctetVectorToObject(bytes, object);
    copy = dynamic_cast<const Map&>(*object);
}

TEST(OctomapDefects, SerializingAConstMapChangesIt) {
    const auto scan = cloudOf(kInSensor);
    COctoMap stock(kResolution), stockCopy(kResolution);
    for (int i = 0; i < 2; ++i) stock.insertObservation(scan);
    const double before = stockOccupancy(stock, kInSensor);
    EXPECT_NEAR(before, 0.845, 0.001);
    serializeAndReadBack(std::as_const(stock), stockCopy);
    EXPECT_NEAR(stockOccupancy(stock, kInSensor), 0.971, 0.001) << "stock: repaired";

    for (const auto& map : ourMaps()) {
        TMapOptions options = test::interfaceOf(*map).options();
        options.insertion.setPolicy(UpdatePolicy::oncePerScan);
        test::interfaceOf(*map).setOptions(options);
        for (int i = 0; i < 2; ++i) map->insertObservation(scan);
        const auto digest = test::interfaceOf(*map).digest();
        std::vector<std::uint8_t> bytes;
        mrpt::serialization::ObjectToOctetVector(map.get(), bytes);
        EXPECT_EQ(test::interfaceOf(*map).digest(), digest);
        EXPECT_NEAR(ourOccupancy(*map, kInSensor), before, 0.001);
    }
}

TEST(OctomapDefects, SerializingDropsInsertionOptions) {
    COctoMap stock(kResolution), stockCopy(kResolution);
    stock.insertionOptions.maxrange = 4.5;
    stock.insertionOptions.setProbHit(0.8);
    serializeAndReadBack(std::as_const(stock), stockCopy);
    EXPECT_NE(stockCopy.insertionOptions.maxrange, 4.5) << "stock: repaired";

    CSuperRayOctoMap ours(kResolution), copy(kResolution);
    ours.insertionOptions.maxrange = 4.5;
    ours.insertionOptions.probHit = 0.8;
    serializeAndReadBack(std::as_const(ours), copy);
    EXPECT_EQ(copy.insertionOptions.maxrange, 4.5);
    EXPECT_EQ(copy.insertionOptions.probHit, 0.8);
}

TEST(OctomapDefects, AnEmptyMapIsNotCalledEmpty) {
    EXPECT_FALSE(COctoMap(kResolution).isEmpty()) << "stock: repaired";
    for (const auto& map : ourMaps()) {
        EXPECT_TRUE(map->isEmpty());
        map->insertObservation(cloudOf(kInSensor));
        EXPECT_FALSE(map->isEmpty());
    }
}

TEST(OctomapDefects, UnknownSpaceScoresAboveTrueHits) {
    const auto scan = denseWall();
    const CPose3D truth, away(0, 0, 50, 0, 0, 0);
    COctoMap stock(kResolution);
    stock.insertObservation(scan);
    EXPECT_GT(stock.computeObservationLikelihood(scan, away),
              stock.computeObservationLikelihood(scan, truth))
        << "stock: repaired";
    for (const auto& map : ourMaps()) {
        map->insertObservation(scan);
        for (const double unknown : {0.01, 0.1, 1.0}) {
            dynamic_cast<CSuperRayMapBase<3>&>(*map).likelihoodOptions.unknownLikelihood =
                unknown;
            const double there = map->computeObservationLikelihood(scan, away);
            const double here = map->computeObservationLikelihood(scan, truth);
            EXPECT_LE(there, here);
            if (unknown < 1) {
                EXPECT_LT(there, here - 100);
            }
        }
    }
}

}  // namespace
}  // namespace superray
