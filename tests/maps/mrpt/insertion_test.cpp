// SPDX-License-Identifier: BSD-3-Clause
// Inserting observations: every method and storage gives the same map.

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/img/CImage.h>
#include <mrpt/io/CFileOutputStream.h>
#include <mrpt/io/lazy_load_path.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/serialization/CArchive.h>
#include <superray/core/reference_mapper.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayQuadMap.h>
#include <superray/maps/observation_rays.h>

#include <map>
#include <set>

#include "maps/test_scans.h"

namespace superray {
namespace {

const std::vector<Method> kMethods{Method::reference, Method::perRay, Method::superRays,
                                   Method::culling,   Method::full,   Method::automatic};

/// Digests by dimension of all classes, methods and thread counts.
std::map<int, std::set<std::string>> digestsOf(const std::vector<test::PosedScan>& scans,
                                               double resolution, UpdatePolicy policy,
                                               std::size_t& runs) {
    std::map<int, std::set<std::string>> digests;
    for (const auto& className : mapClassNames())
        for (const Method method : kMethods)
            for (const unsigned threads : {1u, 2u}) {
                if (method == Method::reference && threads > 1) continue;
                const auto map = createMap(className);
                auto& super = test::interfaceOf(*map);
                TMapOptions o = super.options();
                o.creation.resolution = resolution;
                o.insertion.method = method;
                o.insertion.policy = policy;
                o.insertion.threads = threads;
                o.insertion.insertNoReturnRays = true;
                // Keeps the reference mapper's share of the test in seconds.
                o.insertion.maxrange = 20;
                o.insertion.decimation = scans.size() > 1 ? 1 : 4;
                super.setOptions(o);
                for (const auto& s : scans)
                    EXPECT_TRUE(map->insertObservation(*s.scan, s.robotPose));
                EXPECT_EQ(super.totals().scans, scans.size());
                EXPECT_GT(super.cellTotals().occupied, 100u);
                digests[super.dimension()].insert(super.digest());
                ++runs;
            }
    return digests;
}

void expectOneDigestPerDimension(const std::vector<test::PosedScan>& scans, double resolution) {
    std::size_t runs = 0;
    std::set<std::string> all;
    for (const auto policy : kUpdatePolicies) {
        const auto digests = digestsOf(scans, resolution, policy, runs);
        ASSERT_EQ(digests.size(), 2u);
        for (const auto& [dimension, set] : digests) {
            EXPECT_EQ(set.size(), 1u) << dimension << "D";
            all.insert(set.begin(), set.end());
        }
    }
    EXPECT_EQ(runs, 3u * 4u * 11u);
    EXPECT_EQ(all.size(), 6u) << "dimensions and policies do differ";
}

TEST(Insertion, AllMethodsAndStoragesAgreeOnRandomClouds) {
    std::vector<test::PosedScan> scans;
    for (unsigned i = 0; i < 4; ++i)
        scans.push_back(
            {test::someRobotPose() + mrpt::poses::CPose3D(0.2 * i, 0, 0, 0.3 * i, 0, 0),
             test::randomCloud(3000, 10 + i)});
    expectOneDigestPerDimension(scans, 0.1);
}

TEST(Insertion, AllMethodsAndStoragesAgreeOnTheDebianScans) {
    const auto rgbd = test::mrptDataset("tests_rgbd.rawlog");
    const auto vlp16 = test::mrptDataset("test_velodyne_VLP16.rawlog");
    SUPERRAY_SKIP_WITHOUT(rgbd);
    SUPERRAY_SKIP_WITHOUT(vlp16);
    const auto images = test::readScans(rgbd, 1);
    const auto sweeps = test::readScans(vlp16, 1);
    ASSERT_EQ(images.size() + sweeps.size(), 2u);
    expectOneDigestPerDimension(images, 0.1);
    expectOneDigestPerDimension(sweeps, 0.2);
}

TEST(Insertion, TheMapHoldsWhatTheReferenceMapperSays) {
    const auto scan = test::randomCloud(2000, 5);
    CSuperRayGridMap3D map(0.1);
    map.insertionOptions.maxrange = 3;
    ASSERT_TRUE(map.insertObservation(*scan, test::someRobotPose()));
    TInsertionReport report;
    const auto rays = toRays(*readReturns(*scan, {}), test::someRobotPose(),
                             CellGeometry<3>(0.1), map.insertionOptions, report);
    ReferenceMapper<3> reference(map.sensorModel(), map.insertionOptions.policy);
    reference.insert(rays);
    ASSERT_GT(reference.cells().size(), 5000u);
    for (const auto& [cell, value] : reference.cells()) {
        const auto stored = map.storage().logOdds(cell);
        ASSERT_TRUE(stored);
        EXPECT_EQ(*stored, value);
    }
    EXPECT_EQ(map.summary().known, reference.cells().size());
}

TEST(Insertion, FreshMapsAreEmptyAndClearEmptiesThem) {
    for (const auto& className : mapClassNames()) {
        const auto map = createMap(className);
        EXPECT_TRUE(map->isEmpty()) << className;
        const auto fresh = test::interfaceOf(*map).digest();
        ASSERT_TRUE(map->insertObservation(*test::randomCloud(100, 1)));
        EXPECT_FALSE(map->isEmpty());
        EXPECT_NE(test::interfaceOf(*map).digest(), fresh);
        map->clear();
        EXPECT_TRUE(map->isEmpty());
        EXPECT_EQ(test::interfaceOf(*map).digest(), fresh);
        EXPECT_EQ(test::interfaceOf(*map).totals().scans, 0u);
        EXPECT_CONTAINS(map->asString(), className);
    }
}

TEST(Insertion, MemoryIsReservedWhenAMapIsMadeAndCleared) {
    constexpr std::size_t kLittle = 1u << 20;
    const auto scan = test::randomCloud(1000, 3);
    for (const auto& className : mapClassNames()) {
        const auto plain = createMap(className), map = createMap(className);
        plain->insertObservation(*scan);
        auto& super = test::interfaceOf(*map);
        TMapOptions o = super.options();
        EXPECT_EQ(o.creation.reserve_megabytes, 0u);
        o.creation.reserve_megabytes = 16;
        super.setOptions(o);
        const std::size_t reserved = super.memoryBytes();
        EXPECT_GT(reserved, 10u << 20) << className;
        EXPECT_LT(reserved, 13u << 20) << className;

        EXPECT_TRUE(map->insertObservation(*scan));
        EXPECT_EQ(super.digest(), test::interfaceOf(*plain).digest());
        const std::size_t used = super.memoryBytes();
        super.setOptions(super.options());
        EXPECT_EQ(super.memoryBytes(), used) << "options as they were reserve nothing";

        map->clear();
        EXPECT_TRUE(map->isEmpty());
        EXPECT_GE(super.memoryBytes() + kLittle, reserved) << className;
        EXPECT_LE(super.memoryBytes(), reserved + kLittle) << className;
        o = super.options();
        o.creation.resolution *= 2;
        super.setOptions(o);
        EXPECT_GE(super.memoryBytes() + kLittle, reserved) << className;
        EXPECT_LE(super.memoryBytes(), reserved + kLittle) << className;
        o.creation.reserve_megabytes = 0;
        o.creation.resolution *= 2;
        super.setOptions(o);
        EXPECT_LT(super.memoryBytes(), kLittle) << "a new storage reserves what is asked now";
        map->clear();
        EXPECT_LT(super.memoryBytes(), kLittle) << className;
    }
}

TEST(Insertion, UnsupportedEmptyAndUnwantedObservationsChangeNothing) {
    CSuperRayOctoMap map(0.1);
    EXPECT_FALSE(map.insertObservation(mrpt::obs::CObservationOdometry()));
    EXPECT_FALSE(map.insertObservation(mrpt::obs::CObservation3DRangeScan()));
    EXPECT_FALSE(map.insertObservation(mrpt::obs::CObservationVelodyneScan()));
    EXPECT_FALSE(map.insertObservation(mrpt::obs::CObservationPointCloud()));
    EXPECT_FALSE(map.insertObservation(mrpt::obs::CObservation2DRangeScan()));
    EXPECT_FALSE(map.insertObservation(*test::randomCloud(0, 1)));
    const auto scan = test::randomCloud(100, 1);
    map.insertionOptions.sensorLabel = "OTHER";
    EXPECT_FALSE(map.insertObservation(*scan));
    map.insertionOptions.sensorLabel = "";
    map.genericMapParams.enableObservationInsertion = false;
    EXPECT_FALSE(map.insertObservation(*scan));
    EXPECT_TRUE(map.isEmpty());
    map.genericMapParams.enableObservationInsertion = true;
    EXPECT_TRUE(map.insertObservation(*scan));
}

TEST(Insertion, BadPosesAndMissingFilesAreErrorsThatLeaveTheMap) {
    CSuperRayGridMap3D map(0.1);
    ASSERT_TRUE(map.insertObservation(*test::randomCloud(100, 1)));
    const auto before = map.digest();
    const double nan = std::nan("");
    EXPECT_CONTAINS(test::messageOf([&] {
                        map.insertObservation(*test::randomCloud(100, 2),
                                              mrpt::poses::CPose3D(nan, 0, 0, 0, 0, 0));
                    }),
                    "sensor origin");
    auto external = test::randomCloud(1, 1);
    external->setAsExternalStorage(
        "/no/such/cloud.bin",
        mrpt::obs::CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
    external->pointcloud.reset();
    EXPECT_CONTAINS(test::messageOf([&] { map.insertObservation(*external); }),
                    "/no/such/cloud.bin");
    EXPECT_EQ(map.digest(), before);
    EXPECT_EQ(map.totals().scans, 1u);
}

TEST(Insertion, ExternalObservationsAreFoundByAnOptionAndUnloaded) {
    const test::TempFolder folder;
    const auto cloud = test::randomCloud(200, 3);
    const auto file = folder.file("cloud.bin");
    {
        mrpt::io::CFileOutputStream stream(file);
        mrpt::serialization::archiveFrom(stream) << *cloud->pointcloud;
    }
    CSuperRayGridMap3D expected(0.1), map(0.1);
    ASSERT_TRUE(expected.insertObservation(*cloud));
    auto external = test::randomCloud(1, 1);
    external->sensorPose = cloud->sensorPose;
    external->setAsExternalStorage(
        "cloud.bin",
        mrpt::obs::CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
    external->pointcloud.reset();
    EXPECT_ANY_THROW(map.insertObservation(*external)) << "not in the current folder";

    const auto before = mrpt::io::getLazyLoadPathBase();
    const auto imagesBefore = mrpt::img::CImage::getImagesPathBase();
    mrpt::config::CConfigFileMemory config;
    config.write("m_creationOpts", "lazy_load_path", file.substr(0, file.rfind('/')));
    map.setOptionsFromConfig(config, "m");
    ASSERT_TRUE(map.insertObservation(*external));
    EXPECT_EQ(map.digest(), expected.digest());
    EXPECT_FALSE(external->pointcloud) << "unloaded again";
    EXPECT_EQ(map.optionsAsIniText(), expected.optionsAsIniText())
        << "of the process, not kept";
    mrpt::io::setLazyLoadPathBase(before);
    mrpt::img::CImage::setImagesPathBase(imagesBefore);
}

TEST(Insertion, TheReportCountsRaysAndWhatWasLeftOut) {
    auto scan = test::randomCloud(100, 1);
    scan->pointcloud->insertPoint(std::nanf(""), 0, 0);
    scan->pointcloud->insertPoint(1e7f, 0, 0);
    scan->pointcloud->insertPoint(0, 0, 0);
    CSuperRayGridMap3D map(0.1);
    ASSERT_TRUE(map.insertObservation(*scan));
    EXPECT_EQ(map.lastInsertion().rays, 100u);
    EXPECT_EQ(map.lastInsertion().skipped.notFinite, 1u);
    EXPECT_EQ(map.lastInsertion().skipped.outOfRange, 1u);
    EXPECT_EQ(map.lastInsertion().noReturns, 1u);
    EXPECT_EQ(map.lastInsertion().work.rays, 100u);
    ASSERT_TRUE(map.insertObservation(*scan));
    EXPECT_EQ(map.totals().scans, 2u);
    EXPECT_EQ(map.totals().rays, 200u);
    EXPECT_EQ(map.totals().skipped.total(), 4u);
    EXPECT_GT(map.totals().integrateSeconds, 0);
}

TEST(Insertion, ChangedOptionsTakeEffectAtTheNextInsertion) {
    const auto scan = test::randomCloud(200, 1);
    CSuperRayGridMap3D map(0.1);
    map.insertionOptions.probHit = 0.5;
    const auto fresh = map.digest();
    EXPECT_CONTAINS(test::messageOf([&] { map.insertObservation(*scan); }), "probHit = 0.5");
    EXPECT_EQ(map.digest(), fresh);
    map.insertionOptions.probHit = 0.9;
    ASSERT_TRUE(map.insertObservation(*scan));
    float highest = 0;
    map.storage().forEachBlock([&](const BlockView<3>& b) {
        for (int i = 0; i < kBlockCells<3>; ++i)
            if (b.known.test(i)) highest = std::max(highest, b.values[i]);
    });
    EXPECT_GE(highest, logOddsOf(0.9));
}

TEST(Insertion, NoReturnRaysClearSpaceOnlyWhenAsked) {
    const auto scan = test::planarScan();
    CSuperRayGridMap2D without(0.1), with(0.1);
    with.insertionOptions.insertNoReturnRays = true;
    ASSERT_TRUE(without.insertObservation(*scan));
    ASSERT_TRUE(with.insertObservation(*scan));
    EXPECT_EQ(without.lastInsertion().rays, 45u);
    EXPECT_EQ(with.lastInsertion().rays, 91u);
    EXPECT_GT(with.summary().free, without.summary().free + 1000);
    EXPECT_EQ(with.summary().occupied, without.summary().occupied);
}

TEST(Insertion, ResolutionChangesOnlyWhileEmpty) {
    CSuperRayQuadMap map(0.1);
    EXPECT_THROW(map.setResolution(0), std::invalid_argument);
    EXPECT_THROW(map.setResolution(-1), std::invalid_argument);
    EXPECT_THROW(CSuperRayGridMap3D(0.0), std::invalid_argument);
    map.setResolution(0.25);
    EXPECT_EQ(map.resolution(), 0.25);
    ASSERT_TRUE(map.insertObservation(*test::planarScan()));
    EXPECT_NO_THROW(map.setResolution(0.25));
    EXPECT_THROW(map.setResolution(0.5), std::logic_error);
    EXPECT_EQ(map.resolution(), 0.25);
    const auto bounds = map.metricBounds();
    ASSERT_TRUE(bounds);
    EXPECT_LT(bounds->lowest.x(), bounds->highest.x());
    EXPECT_LE(bounds->highest.x(), 3.5);
    EXPECT_FLOAT_EQ(map.boundingBox().max.x, static_cast<float>(bounds->highest.x()));
    EXPECT_FALSE(CSuperRayQuadMap().metricBounds());
}

TEST(Insertion, RaysOfTheCaller) {
    CSuperRayGridMap2D map(0.5);
    RayBundle<2> rays(CellGeometry<2>(0.5), {0.1, 0.1});
    rays.add({2.1, 0.1});
    rays.add({std::nan(""), 0.1});
    map.insertRays(rays);
    EXPECT_EQ(map.lastInsertion().rays, 1u);
    EXPECT_EQ(map.lastInsertion().skipped.notFinite, 1u);
    EXPECT_EQ(map.summary().known, 5u);
    EXPECT_EQ(map.summary().occupied, 1u);
    EXPECT_EQ(*map.storage().logOdds({4, 0}), map.sensorModel().hit());
    const RayBundle<2> other(CellGeometry<2>(0.25), {0, 0});
    EXPECT_CONTAINS(test::messageOf([&] { map.insertRays(other); }),
                    "rays made for cells of 0.25 m; must be 0.5 m");

    const std::string digest = map.digest();
    map.insertionOptions.windowRadius = std::nan("");
    EXPECT_CONTAINS(test::messageOf([&] { map.insertRays(rays); }), "windowRadius = nan");
    EXPECT_EQ(map.digest(), digest);
}

TEST(Insertion, ThePoseOfTheRobotCountsAtInsertion) {
    // The same world point from two places ends in one cell.
    const mrpt::poses::CPose3D a = test::someRobotPose(), b(-1, 2, 0.5, -0.7, 0.2, -0.1);
    const mrpt::math::TPoint3D p_map(3.05, 1.05, 2.05);
    CSuperRayGridMap3D map(0.1);
    for (const auto& robot : {a, b}) {
        const auto T = robot + test::someSensorPose();
        mrpt::math::TPoint3D p;
        T.inverseComposePoint(p_map.x, p_map.y, p_map.z, p.x, p.y, p.z);
        auto scan = test::randomCloud(0, 1);
        scan->pointcloud->insertPoint(static_cast<float>(p.x), static_cast<float>(p.y),
                                      static_cast<float>(p.z));
        ASSERT_TRUE(map.insertObservation(*scan, robot));
        const auto origin = map.storage().geometry().cellOf({T.x(), T.y(), T.z()});
        EXPECT_EQ(*map.storage().logOdds(origin), map.sensorModel().miss());
    }
    const SensorModel model = map.sensorModel();
    EXPECT_EQ(*map.storage().logOdds({30, 10, 20}), std::min(2 * model.hit(), model.max()));
    EXPECT_EQ(map.summary().occupied, 1u);
}

}  // namespace
}  // namespace superray
