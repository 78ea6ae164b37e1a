// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <superray/eval/input_error.h>
#include <superray/eval/map_build.h>
#include <superray/eval/map_request.h>
#include <superray/maps/CSuperRayGridMap3D.h>

#include "eval/recorded_scans.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;
using mrpt::poses::CPose3D;

constexpr auto kNoLimit = std::numeric_limits<std::uint64_t>::max();

std::string recording(const TempFolder& folder, const std::string& name, int scans) {
    Objects objects;
    for (int i = 0; i < scans; ++i) {
        objects.push_back(makePose(i, CPose3D(0.3 * i, 0.1, 0, 0.2 * i, 0, 0)));
        objects.push_back(makeCloud(i, static_cast<unsigned>(i)));
    }
    return writeRawlog(folder / name, objects);
}

TEST(BuildMap, insertsAllScansAndAccountsForThem) {
    TempFolder folder;
    ScanSources sources;
    sources.push_back(openScanSource(recording(folder, "a.rawlog", 3)));
    sources.push_back(openScanSource(recording(folder, "b.rawlog", 4)));
    CSuperRayGridMap3D map(0.2);
    std::vector<std::uint64_t> seen;
    const auto report = buildMap(sources, map, kNoLimit, [&](const BuildProgress& p) {
        seen.push_back(p.scans);
        EXPECT_EQ(p.totalScans, 7u);
        EXPECT_EQ(p.rays, 50 * p.scans);
    });
    EXPECT_EQ(seen, (std::vector<std::uint64_t>{1, 2, 3, 4, 5, 6, 7}));
    EXPECT_EQ(report.scans, 7u);
    EXPECT_EQ(report.unusable, 0u);
    EXPECT_EQ(report.insertion.rays, 350u);
    EXPECT_EQ(report.insertion.scans, 7u);

    CSuperRayGridMap3D byHand(0.2);
    for (const char* name : {"a.rawlog", "b.rawlog"}) {
        const auto source = openScanSource(folder / name);
        while (const auto scan = source->next())
            ASSERT_TRUE(byHand.insertObservation(*scan->observation, scan->T_map_robot));
    }
    EXPECT_EQ(map.digest(), byHand.digest());
    EXPECT_GT(map.cellTotals().occupied, 100u);

    const auto text = describe(report);
    EXPECT_NE(text.find("scans      7 in"), std::string::npos) << text;
    EXPECT_NE(text.find("left out   nothing"), std::string::npos) << text;
}

/// A laser that sees a wall all around it, 3 m away.
mrpt::obs::CObservation2DRangeScan::Ptr makeLaserScan(double seconds) {
    auto scan = mrpt::obs::CObservation2DRangeScan::Create();
    scan->timestamp = test::at(seconds);
    scan->sensorLabel = "LASER";
    scan->aperture = 6.0f;
    scan->maxRange = 20;
    scan->resizeScanAndAssign(361, 3.0f, true);
    return scan;
}

TEST(BuildMap, saysWhyNoPointOfAnyScanIsUsed) {
    TempFolder folder;
    const auto errorOf = [&](const mrpt::obs::CObservation::Ptr& scan, double minimum) {
        ScanSourceOptions still;
        still.poses = PoseOrigin::fixed;
        ScanSources sources;
        sources.push_back(openScanSource(writeRawlog(folder / "a.rawlog", {scan}), still));
        CSuperRayGridMap3D map(0.1);
        map.insertionOptions.minrange = minimum;
        return test::messageOf<InputError>(
            [&] { buildMap(sources, map, kNoLimit, [](const BuildProgress&) {}); });
    };
    const auto cloudAt = [](float x) {
        auto scan = mrpt::obs::CObservationPointCloud::Create();
        scan->timestamp = test::at(1);
        auto points = mrpt::maps::CSimplePointsMap::Create();
        points->insertPoint(x, 0, 0);
        scan->pointcloud = points;
        return scan;
    };
    EXPECT_NE(errorOf(cloudAt(5000), 0).find("left out, 1 beyond the cells that can be"),
              std::string::npos)
        << errorOf(cloudAt(5000), 0);
    EXPECT_NE(errorOf(cloudAt(std::nanf("")), 0).find("left out, 1 not finite"),
              std::string::npos);
    EXPECT_NE(errorOf(cloudAt(1), 2).find("left out, 1 nearer than minrange"),
              std::string::npos);
}

TEST(BuildMap, deskewsAlongThePosesOfTheInput) {
    TempFolder folder;
    test::Objects objects;
    for (int i = 0; i < 4; ++i) {
        objects.push_back(makePose(i, CPose3D(2.0 * i, 0, 0, 0.3 * i, 0, 0)));
        if (i < 3) objects.push_back(makeLaserScan(i));
    }
    const auto file = writeRawlog(folder / "moving.rawlog", objects);
    const auto build = [&](double sweep, ScanMotion motion) {
        ScanSources sources;
        sources.push_back(openScanSource(file));
        auto map = std::make_unique<CSuperRayGridMap3D>(0.1);
        map->insertionOptions.sweepDuration = sweep;
        const auto report = buildMap(
            sources, *map, kNoLimit, [](const BuildProgress&) {}, motion);
        EXPECT_EQ(report.insertion.rays + report.insertion.withoutPose, 3 * 361u);
        EXPECT_EQ(report.insertion.withoutPose > 0, sweep > 1);
        if (sweep > 1) {
            EXPECT_NE(describe(report).find("rays outside the time of the poses"),
                      std::string::npos);
        }
        return map;
    };
    const auto moving = build(0.5, ScanMotion::alongTrajectory);
    CSuperRayGridMap3D byHand(0.1);
    byHand.insertionOptions.sweepDuration = 0.5;
    Trajectory trajectory;
    for (int i = 0; i < 4; ++i)
        trajectory.add(test::at(i), CPose3D(2.0 * i, 0, 0, 0.3 * i, 0, 0));
    for (int i = 0; i < 3; ++i)
        ASSERT_TRUE(byHand.insertObservationAlong(
            *makeLaserScan(i), [&](mrpt::Clock::time_point t) { return trajectory.at(t); }));
    EXPECT_EQ(moving->digest(), byHand.digest());
    EXPECT_NE(moving->digest(), build(0.5, ScanMotion::none)->digest());
    build(1.5, ScanMotion::alongTrajectory);  // the last scan outlasts the poses

    ScanSourceOptions still;
    still.poses = PoseOrigin::fixed;
    ScanSources sources;
    sources.push_back(openScanSource(file, still));
    CSuperRayGridMap3D map(0.1);
    EXPECT_THROW(
        buildMap(
            sources, map, kNoLimit, [](const BuildProgress&) {}, ScanMotion::alongTrajectory),
        InputError);
}

TEST(BuildMap, stopsAtTheLimit) {
    TempFolder folder;
    ScanSources sources;
    sources.push_back(openScanSource(recording(folder, "a.rawlog", 3)));
    sources.push_back(openScanSource(recording(folder, "b.rawlog", 4)));
    CSuperRayGridMap3D map(0.2);
    std::uint64_t calls = 0;
    const auto report = buildMap(sources, map, 5, [&](const BuildProgress& p) {
        EXPECT_EQ(p.totalScans, 5u);
        ++calls;
    });
    EXPECT_EQ(calls, 5u);
    EXPECT_EQ(report.scans, 5u);
}

TEST(BuildMap, countsWhatIsLeftOut) {
    TempFolder folder;
    auto withNan = makeCloud(1, 1);
    withNan->pointcloud->setPoint(3, std::nanf(""), 0.0f, 0.0f);
    auto empty = mrpt::obs::CObservationPointCloud::Create();
    empty->timestamp = at(1);
    const auto path = writeRawlog(
        folder / "a.rawlog",
        {makePose(0, CPose3D()), makePose(2, CPose3D()), withNan, empty, makeCloud(9, 2)});
    ScanSources sources;
    sources.push_back(openScanSource(path));
    CSuperRayGridMap3D map(0.2);
    const auto report = buildMap(sources, map, kNoLimit, [](const BuildProgress&) {});
    EXPECT_EQ(report.scans, 2u);
    EXPECT_EQ(report.unusable, 1u);
    EXPECT_EQ(report.skipped.withoutPose, 1u);
    EXPECT_EQ(report.insertion.skipped.notFinite, 1u);
    EXPECT_EQ(report.insertion.rays, 49u);
    const auto text = describe(report);
    EXPECT_NE(text.find("points not finite"), std::string::npos) << text;
    EXPECT_NE(text.find("scans outside the time of the poses"), std::string::npos) << text;
}

TEST(BuildMap, refusesToMakeAnEmptyMap) {
    TempFolder folder;
    auto empty = mrpt::obs::CObservationPointCloud::Create();
    empty->timestamp = at(0);
    ScanSources sources;
    sources.push_back(
        openScanSource(writeRawlog(folder / "a.rawlog", {makePose(0, CPose3D()), empty})));
    CSuperRayGridMap3D map(0.2);
    EXPECT_THROW(buildMap(sources, map, kNoLimit, [](const BuildProgress&) {}), InputError);
}

TEST(BuildMap, namesTheScanThatCannotBeInserted) {
    TempFolder folder;
    auto external = makeCloud(1, 7);
    external->pointcloud.reset();
    external->setAsExternalStorage(
        "absent.bin",
        mrpt::obs::CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
    ScanSources sources;
    sources.push_back(openScanSource(
        writeRawlog(folder / "a.rawlog", {makePose(1, CPose3D()), makeCloud(1, 1), external})));
    CSuperRayGridMap3D map(0.2);
    const auto message = messageOf<InputError>(
        [&] { buildMap(sources, map, kNoLimit, [](const BuildProgress&) {}); });
    EXPECT_NE(message.find("scan 2 (sensor 'LIDAR') cannot be inserted"), std::string::npos)
        << message;
}

TMapOptions optionsOf(const MapRequest& request, std::string* className = nullptr) {
    const auto map = makeMap(request);
    const auto& info = dynamic_cast<const SuperRayMapInterface&>(*map);
    if (className != nullptr) *className = info.shortClassName();
    return info.options();
}

TEST(MakeMap, withoutARequestIsTheDefaultMap) {
    std::string name;
    const auto options = optionsOf({}, &name);
    EXPECT_EQ(name, "CSuperRayGridMap3D");
    EXPECT_EQ(options.toText(), TMapOptions().toText());
}

TEST(MakeMap, takesSingleOptions) {
    MapRequest request;
    request.className = "CSuperRayQuadMap";
    request.resolution = 0.25;
    request.maxRange = 20;
    request.minRange = 0.5;
    request.policy = "oncePerScan";
    request.method = "culling";
    request.sensorLabels = "A,B";
    request.threads = 3;
    std::string name;
    const auto options = optionsOf(request, &name);
    EXPECT_EQ(name, "CSuperRayQuadMap");
    EXPECT_EQ(options.creation.resolution, 0.25);
    EXPECT_EQ(options.insertion.maxrange, 20);
    EXPECT_EQ(options.insertion.minrange, 0.5);
    EXPECT_EQ(options.insertion.policy, UpdatePolicy::oncePerScan);
    EXPECT_EQ(options.insertion.method, Method::culling);
    EXPECT_EQ(options.insertion.sensorLabel, "A,B");
    EXPECT_EQ(options.insertion.threads, 3u);
}

TEST(MakeMap, readsSectionsByPrefixAndOptionsOverrideThem) {
    TempFolder folder;
    MapRequest request;
    request.configFile = folder.write("a.ini",
                                      "[room_creationOpts]\nresolution = 0.05\n"
                                      "[room_insertOpts]\nprobHit = 0.8\nmaxrange = 7\n");
    request.section = "room";
    auto options = optionsOf(request);
    EXPECT_EQ(options.creation.resolution, 0.05);
    EXPECT_EQ(options.insertion.probHit, 0.8);
    EXPECT_EQ(options.insertion.maxrange, 7);
    request.resolution = 0.5;
    request.maxRange = 9;
    options = optionsOf(request);
    EXPECT_EQ(options.creation.resolution, 0.5);
    EXPECT_EQ(options.insertion.probHit, 0.8);
    EXPECT_EQ(options.insertion.maxrange, 9);
}

TEST(MakeMap, readsAMultiMetricMapSection) {
    TempFolder folder;
    MapRequest request;
    request.configFile =
        folder.write("a.ini",
                     "[maps]\nsuperRayOctoMap_count = 1\n"
                     "[maps_superRayOctoMap_00_creationOpts]\nresolution = 0.05\n"
                     "[maps_superRayOctoMap_00_insertOpts]\nprobHit = 0.8\n");
    request.section = "maps";
    std::string name;
    auto options = optionsOf(request, &name);
    EXPECT_EQ(name, "CSuperRayOctoMap");
    EXPECT_EQ(options.creation.resolution, 0.05);
    EXPECT_EQ(options.insertion.probHit, 0.8);
    request.className = "CSuperRayGridMap3D";
    options = optionsOf(request, &name);
    EXPECT_EQ(name, "CSuperRayGridMap3D");
    EXPECT_EQ(options.creation.resolution, 0.05);
    EXPECT_EQ(options.insertion.probHit, 0.8);
}

TEST(MakeMap, saysWhatIsWrong) {
    TempFolder folder;
    const auto errorOf = [](const MapRequest& request) {
        return messageOf<std::exception>([&] { makeMap(request); });
    };
    const auto withConfig = [&](const std::string& contents, const std::string& section) {
        MapRequest request;
        request.configFile = folder.write("a.ini", contents);
        request.section = section;
        return errorOf(request);
    };
    const auto expectPart = [](const std::string& message, const std::string& part) {
        EXPECT_NE(message.find(part), std::string::npos) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    };
    expectPart(withConfig("[a]\nb=1\n", ""), "which section");
    expectPart(withConfig("[a]\nb=1\n", "map"), "has neither a section [map]");
    expectPart(withConfig("[map_insertOpts]\nprobHit = 0.4\n", "map"), "probHit");
    expectPart(withConfig("[map_insertOpts]\nprobHit = high\n", "map"), "probHit");
    expectPart(withConfig("[map_insertOpts]\nprobabilityHit = 0.7\n", "map"), "probabilityHit");
    expectPart(withConfig("[map_creationOpts]\nresolution = -1\n", "map"), "resolution");
    expectPart(withConfig("[map]\npointsMap_count = 1\n", "map"), "no superray map");
    MapRequest request;
    request.section = "map";
    expectPart(errorOf(request), "needs a configuration file");
    request.configFile = folder / "absent.ini";
    expectPart(errorOf(request), "no such file");
    request = {};
    request.className = "COctoMap";
    expectPart(errorOf(request), "COctoMap");
    request = {};
    request.method = "fast";
    expectPart(errorOf(request), "fast");
    request = {};
    request.policy = "sometimes";
    expectPart(errorOf(request), "sometimes");
    request = {};
    request.resolution = 0;
    expectPart(errorOf(request), "resolution");
}

}  // namespace
}  // namespace superray
