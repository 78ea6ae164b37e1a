// SPDX-License-Identifier: BSD-3-Clause
// What scans of recordings become in a map: dirt that users' recordings have.

#include <gtest/gtest.h>
#include <mrpt/io/CFileOutputStream.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <superray/eval/input_error.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayQuadMap.h>

#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "eval/sources/map_of_recording.h"
#include "eval/sources/room_scans.h"
#include "eval/temp_folder.h"
#include "gzip_bytes.h"

namespace superray {
namespace {

using namespace test;
using mrpt::poses::CPose2D;
using mrpt::poses::CPose3D;

constexpr double kDegree = M_PI / 180;

// --- no returns --------------------------------------------------------------

TEST(RecordedSensors, rangeZeroIsNoReturn) {
    TempFolder folder;
    // Of a laser that flags its zeros valid, and of a rotating scan of one row.
    auto laser = roomScan(0, 0);
    auto rotating = mrpt::obs::CObservationRotatingScan::Create();
    rotating->timestamp = at(0);
    rotating->rowCount = 1;
    rotating->columnCount = 100;
    rotating->rangeImage.setSize(1, 100);
    rotating->rangeResolution = 0.01;
    rotating->minRange = 0;
    for (int i = 0; i < 100; ++i) rotating->rangeImage(0, i) = i % 3 == 0 ? 0 : 250;
    for (std::size_t i = 0; i < 181; i += 3) laser->setScanRange(i, 0);
    for (const mrpt::obs::CObservation::Ptr& scan :
         {mrpt::obs::CObservation::Ptr(laser), mrpt::obs::CObservation::Ptr(rotating)}) {
        const auto built = buildPlan(writeRawlog(
            folder / "a.rawlog", {makePose(0, CPose3D(0.05, 0.05, 0, 0, 0, 0)), scan}));
        EXPECT_EQ(occupied(*built.map, 0.05, 0.05), false);
        EXPECT_GT(built.report.insertion.noReturns, 30u);
    }
}

TEST(RecordedSensors, beyondTheSensorsMaximumIsNoReturn) {
    TempFolder folder;
    auto scan = roomScan(0, 0);
    scan->maxRange = 5;  // the wall ahead is 8 m away
    scan->setScanRange(90, std::numeric_limits<float>::infinity());
    const auto built =
        buildPlan(writeRawlog(folder / "a.rawlog", {makePose(0, CPose3D()), scan}));
    EXPECT_FALSE(occupied(*built.map, 8.05, 0.05));
    EXPECT_EQ(occupied(*built.map, 0.05, 2.05), true);
    EXPECT_EQ(built.report.insertion.skipped.notFinite, 0u);
    EXPECT_GT(built.report.insertion.noReturns, 10u);

    // Asked to, they clear space up to the maximum.
    CSuperRayGridMap2D clearing(0.1);
    clearing.insertionOptions.insertNoReturnRays = true;
    buildInto(clearing, folder / "a.rawlog");
    EXPECT_EQ(occupied(clearing, 4.85, 0.05), false);
    EXPECT_FALSE(occupied(clearing, 5.15, 0.05));
}

// --- tilted planar scanners --------------------------------------------------

TEST(RecordedSensors, tiltedPlanarScannersAreLeftOutOf2DMaps) {
    TempFolder folder;
    struct Case {
        double pitchDegrees, rollDegrees, tolerance;
        bool isTaken;
    };
    for (const Case& c : {Case{0, 0, 5, true},
                          {30, 0, 5, false},
                          {0, 90, 5, false},
                          {4.9, 0, 5, true},
                          {5.1, 0, 5, false},
                          {0, 180, 5, true},
                          {30, 0, 31, true},
                          {0.5, 0, 0, false}}) {
        auto good = roomScan(0, 0), tilted = roomScan(0, 0, "TILTED");
        tilted->sensorPose =
            CPose3D(0, 0, 1, 0, c.pitchDegrees * kDegree, c.rollDegrees * kDegree);
        const auto path =
            writeRawlog(folder / "a.rawlog", {makePose(0, CPose3D()), good, tilted});
        CSuperRayGridMap2D plan(0.1);
        plan.insertionOptions.horizontalTolerance = c.tolerance;
        const auto report = buildInto(plan, path);
        EXPECT_EQ(report.tiltedScans, c.isTaken ? 0u : 1u) << c.pitchDegrees << c.rollDegrees;
        EXPECT_EQ(report.insertion.tilted, c.isTaken ? 0u : 181u);
        EXPECT_EQ(report.insertion.scans, c.isTaken ? 2u : 1u);
        EXPECT_EQ(describe(report).find("planar scanners too tilted") == std::string::npos,
                  c.isTaken);
        CSuperRayGridMap3D space(0.1);
        EXPECT_EQ(buildInto(space, path).insertion.scans, 2u);
    }
    auto alone = roomScan(0, 0);
    alone->sensorPose = CPose3D(0, 0, 1, 0, 0.5, 0);
    const auto path = writeRawlog(folder / "b.rawlog", {makePose(0, CPose3D()), alone});
    expectPart(messageOf<InputError>([&] { buildPlan(path); }), "horizontalTolerance");
}

TEST(RecordedSensors, theHeightBandAppliesToPlanarScannersToo) {
    TempFolder folder;
    auto low = roomScan(0, 0), high = roomScan(0, 0, "HIGH");
    low->sensorPose = CPose3D(0, 0, 0.3, 0, 0, 0);
    high->sensorPose = CPose3D(0, 0, 2.5, 0, 0, 0);
    const auto path = writeRawlog(folder / "a.rawlog", {makePose(0, CPose3D()), low, high});
    for (const bool is3D : {false, true}) {
        CSuperRayGridMap2D plan(0.1);
        CSuperRayGridMap3D space(0.1);
        for (TInsertionOptions* o : {&plan.insertionOptions, &space.insertionOptions}) {
            o->heightBandMin = 0.1;
            o->heightBandMax = 1.5;
        }
        const auto report = is3D ? buildInto(space, path) : buildInto(plan, path);
        EXPECT_EQ(report.insertion.scans, 1u);
        EXPECT_EQ(report.insertion.outOfHeightBand, 181u);
    }
}

// --- classes and files that are not there -------------------------------------

/// An uncompressed rawlog of which one object has a class that MRPT does not know.
std::string withUnknownClass(const TempFolder& folder, int which) {
    Objects objects;
    for (int i = 0; i < 4; ++i) {
        auto frame = mrpt::obs::CSensoryFrame::Create();
        frame->insert(makePose(i, CPose3D(driveX(i), 0, 0, 0, 0, 0)));
        frame->insert(roomScan(i, driveX(i)));
        objects.push_back(frame);
    }
    const auto path = folder / "unknown.rawlog";
    writeRawlog<mrpt::io::CFileOutputStream>(path, objects);
    std::string bytes = readWholeFile(path);
    const std::string name = "CSensoryFrame";
    std::size_t where = 0;
    for (int i = 0; i <= which; ++i) where = bytes.find(name, where) + name.size();
    bytes[where - 1] = 'X';
    return folder.write("unknown.rawlog", bytes);
}

TEST(RecordedSensors, anUnknownClassIsNamedAndWhatComesBeforeCanBeUsed) {
    TempFolder folder;
    ScanSourceOptions accept;
    accept.truncation = Truncation::accept;
    for (const int which : {0, 1, 3}) {
        const auto path = withUnknownClass(folder, which);
        const auto message = messageOf<InputError>([&] { buildPlan(path); });
        expectPart(message, "CSensoryFramX");
        if (which == 0) continue;  // nothing comes before
        expectPart(message, "newer MRPT");
        expectPart(message, "after " + std::to_string(which) + " whole objects, ");
        // Where the object begins: with a byte for the length of its name.
        const auto name = readWholeFile(path).find("mrpt::obs::CSensoryFramX");
        expectPart(message, "in the one at byte " + std::to_string(name - 1) + " of " +
                                std::to_string(readWholeFile(path).size()));
        expectPart(message, "--accept-truncated");
        const auto built = buildPlan(path, accept);
        EXPECT_EQ(built.report.scans, static_cast<unsigned>(which));
        EXPECT_EQ(built.report.warnings.size(), 1u);
    }
}

TEST(RecordedSensors, anUnknownClassIsNamedInCompressedFilesAndInsideFramesToo) {
    TempFolder folder;
    ScanSourceOptions accept;
    accept.truncation = Truncation::accept;
    // The third sensory frame of a compressed file; then the pose in the third one.
    const auto packed =
        folder.write("packed.rawlog", gzip(readWholeFile(withUnknownClass(folder, 2))));
    std::string bytes = readWholeFile(withUnknownClass(folder, 3));
    bytes.replace(bytes.find("CSensoryFramX"), 13, "CSensoryFrame");
    const std::string name = "CObservationRobotPose";
    std::size_t where = 0;
    for (int i = 0; i < 3; ++i) where = bytes.find(name, where) + name.size();
    bytes[where - 1] = 'X';
    const auto inside = folder.write("inside.rawlog", bytes);
    for (const auto& [path, unknown] :
         {std::pair(packed, "CSensoryFramX"), std::pair(inside, "CObservationRobotPosX")}) {
        const auto message = messageOf<InputError>([&] { buildPlan(path); });
        expectPart(message, unknown);
        expectPart(message, "newer MRPT");
        expectPart(message, "after 2 whole objects, ");
        expectPart(message, "--accept-truncated");
        EXPECT_EQ(buildPlan(path, accept).report.scans, 2u);
    }
}

mrpt::obs::CObservation3DRangeScan::Ptr depthImage() {
    auto scan = mrpt::obs::CObservation3DRangeScan::Create();
    scan->timestamp = at(0);
    scan->sensorLabel = "CAM";
    scan->hasRangeImage = true;
    scan->range_is_depth = true;
    scan->rangeUnits = 0.001f;
    scan->maxRange = 5;
    scan->cameraParams.ncols = 32;
    scan->cameraParams.nrows = 24;
    scan->cameraParams.setIntrinsicParamsFromValues(30, 30, 15.5, 11.5);
    scan->rangeImage.setSize(24, 32);
    scan->rangeImage.fill(2000);
    return scan;
}

TEST(RecordedSensors, externalFilesAreFoundInTheUsualFolders) {
    TempFolder folder;
    const auto build = [&] {
        CSuperRayGridMap3D map(0.1);
        buildInto(map, folder / "cam.rawlog");
        return map.digest();
    };
    writeRawlog(folder / "cam.rawlog", {makePose(0, CPose3D()), depthImage()});
    const auto expected = build();
    auto external = depthImage();
    std::filesystem::create_directory(folder / "made");
    external->rangeImage_convertToExternalStorage("ranges.bin", (folder / "made") + "/");
    const auto data = readWholeFile(folder / "made/ranges.bin");
    writeRawlog(folder / "cam.rawlog", {makePose(0, CPose3D()), external});
    for (const char* name :
         {"cam_Images", "cam_images", "cam_IMAGES", "Images", "images", "."}) {
        const auto file = folder.write(std::string(name) + "/ranges.bin", data);
        EXPECT_EQ(build(), expected) << name;
        std::filesystem::remove(file);
    }
    const auto message = messageOf<InputError>([&] { build(); });
    expectPart(message, "ranges.bin is not there; looked in ");
    expectPart(message, folder / "cam_Images");
    expectPart(message, folder / "Images");
    expectPart(message, "scan 1 (sensor 'CAM')");
}

TEST(RecordedSensors, rotatingScansOfSeveralRowsAreRefusedWithTheReason) {
    TempFolder folder;
    auto scan = mrpt::obs::CObservationRotatingScan::Create();
    scan->timestamp = at(0);
    scan->sensorLabel = "ROTATING";
    scan->rowCount = 16;
    scan->columnCount = 20;
    scan->rangeImage.setSize(16, 20);
    scan->rangeImage.fill(100);
    scan->rangeResolution = 0.01;
    const auto path = writeRawlog(folder / "a.rawlog", {makePose(0, CPose3D()), scan});
    const auto message = messageOf<InputError>([&] { buildPlan(path); });
    expectPart(message, "16 rows");
    expectPart(message, "vertical angles");
    const auto mixed =
        writeRawlog(folder / "b.rawlog", {makePose(0, CPose3D()), scan, roomScan(0, 0)});
    expectPart(describe(buildPlan(mixed).report), "warning    the rotating scan 'ROTATING'");
}

// --- the cases ----------------------------------------------------------------

TEST(RecordingCases, sensorCasesAreMappedAsTheyShould) {
    if (!std::filesystem::exists(casePath("base_odo.rawlog")))
        GTEST_SKIP() << "CASES ABSENT: " << casePath("") << "; NOT TESTED";
    const auto zero = buildPlan(casePath("zero_ranges.rawlog"));
    for (const double x : {0.0, 0.5, 1.0})
        EXPECT_EQ(occupied(*zero.map, x + 0.01, 0.01), false) << x;

    const auto vertical = buildPlan(casePath("vertical_laser.rawlog"));
    EXPECT_GT(vertical.report.tiltedScans, 30u);
    int driven = 0;
    for (double x = 0.01; x < 4; x += 0.1, ++driven)
        EXPECT_NE(occupied(*vertical.map, x, 0.01), true) << x;
    EXPECT_EQ(driven, 40);
    CSuperRayGridMap3D space(0.1);
    EXPECT_EQ(buildInto(space, casePath("vertical_laser.rawlog")).tiltedScans, 0u);

    const auto path = casePath("unregistered_class.rawlog");
    expectPart(messageOf<InputError>([&] { buildPlan(path); }), "CSensoryFramX");
    ScanSourceOptions accept;
    accept.truncation = Truncation::accept;
    EXPECT_EQ(buildPlan(path, accept).report.scans, 3u);

    CSuperRayGridMap3D camera(0.1);
    EXPECT_EQ(buildInto(camera, casePath("ext/cam.rawlog")).insertion.rays, 768u);
}

}  // namespace
}  // namespace superray
