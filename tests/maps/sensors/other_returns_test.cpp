// SPDX-License-Identifier: BSD-3-Clause
// Point clouds, 2D scans, rotating scans, and what all have in common.

#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/serialization/CArchive.h>
#include <superray/maps/mrpt_compat.h>
#include <superray/maps/observation_rays.h>

#include <array>

#include "maps/test_scans.h"

namespace superray {
namespace {

TEST(PointCloud, PointsAreInTheSensorFrame) {
    const auto scan = test::randomCloud(500, 1);
    const auto returns = readReturns(*scan, {});
    ASSERT_TRUE(returns);
    ASSERT_EQ(returns->hits.size(), 500u);
    TInsertionReport report;
    const auto rays = toRays(*returns, test::someRobotPose(), CellGeometry<3>(0.1), {}, report);
    ASSERT_EQ(rays.size(), 500u);
    const auto T = test::someRobotPose() + test::someSensorPose();
    const auto& x = scan->pointcloud->getPointsBufferRef_x();
    const auto& y = scan->pointcloud->getPointsBufferRef_y();
    const auto& z = scan->pointcloud->getPointsBufferRef_z();
    for (std::size_t i = 0; i < 500; ++i) {
        mrpt::math::TPoint3D q;
        T.composePoint(x[i], y[i], z[i], q.x, q.y, q.z);
        EXPECT_LT((rays.end(i) - Point<3>(q.x, q.y, q.z)).norm(), 1e-9);
    }
    EXPECT_LT((rays.commonOrigin() - Point<3>(T.x(), T.y(), T.z())).norm(), 1e-12);
}

TEST(PointCloud, ExternalCloudsAreLoadedAndUnloaded) {
    const test::TempFolder folder;
    auto scan = test::randomCloud(50, 2);
    const auto expected = readReturns(*scan, {});
    {
        mrpt::io::CFileGZOutputStream file(folder.file("cloud.bin"));
        mrpt::serialization::archiveFrom(file) << *scan->pointcloud;
    }
    scan->setAsExternalStorage(
        folder.file("cloud.bin"),
        mrpt::obs::CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
    scan->pointcloud.reset();
    EXPECT_TRUE(canReadReturns(*scan));
    const auto returns = readReturns(*scan, {});
    ASSERT_TRUE(returns);
    EXPECT_EQ(returns->hits, expected->hits);
    EXPECT_FALSE(scan->pointcloud) << "unloaded again";
}

TEST(PointCloud, NothingWithoutACloud) {
    const mrpt::obs::CObservationPointCloud scan;
    EXPECT_FALSE(readReturns(scan, {}));
    EXPECT_FALSE(canReadReturns(scan));
}

TEST(PlanarScan, AnglesRangesAndValidity) {
    auto scan = test::planarScan(91);
    for (const bool rightToLeft : {true, false}) {
        scan->rightToLeft = rightToLeft;
        const auto returns = readReturns(*scan, {1, true, 0});
        ASSERT_TRUE(returns);
        EXPECT_TRUE(returns->planar);
        ASSERT_EQ(returns->hits.size(), 45u);
        ASSERT_EQ(returns->noReturns.size(), 46u);
        for (std::size_t i = 0; i < 91; ++i) {
            const double degrees = (rightToLeft ? 1 : -1) * (static_cast<double>(i) - 45);
            const double angle = degrees * M_PI / 180;
            const bool valid = i % 2 == 1;
            const auto& p = valid ? returns->hits[i / 2] : returns->noReturns[i / 2];
            const double range = valid ? 3 : 20;
            EXPECT_NEAR(p.x(), range * std::cos(angle), 1e-5);
            EXPECT_NEAR(p.y(), range * std::sin(angle), 1e-5);
            EXPECT_EQ(p.z(), 0);
            EXPECT_NEAR(scan->getScanAngle(i), angle, 1e-6);
        }
    }
    EXPECT_TRUE(readReturns(*scan, {})->noReturns.empty());
    EXPECT_EQ(readReturns(*scan, {})->noReturnCount, 46u);
}

TEST(PlanarScan, OneRayLooksForward) {
    auto scan = test::planarScan(1);
    scan->setScanRange(0, 2);
    scan->setScanRangeValidity(0, true);
    const auto returns = readReturns(*scan, {});
    ASSERT_EQ(returns->hits.size(), 1u);
    EXPECT_LT((returns->hits[0] - Eigen::Vector3f(2, 0, 0)).norm(), 1e-6);
    EXPECT_FALSE(readReturns(mrpt::obs::CObservation2DRangeScan(), {}));
}

TEST(PlanarScan, RangesOfZeroAndLessTellNothing) {
    auto scan = test::planarScan(3);
    const float ranges[] = {-1, 0, 2};
    for (std::size_t i = 0; i < 3; ++i) {
        scan->setScanRange(i, ranges[i]);
        scan->setScanRangeValidity(i, true);
    }
    const auto returns = readReturns(*scan, {1, true, 0});
    ASSERT_EQ(returns->hits.size(), 1u);
    EXPECT_GT(returns->hits[0].norm(), 1.9);
    EXPECT_TRUE(returns->noReturns.empty());
    EXPECT_EQ(returns->noReturnCount, 2u);
}

TEST(RotatingScan, OneRowIsAPlanarScan) {
    const auto file = test::mrptDataset("rot_scan_2d.rawlog");
    SUPERRAY_SKIP_WITHOUT(file);
    if (!kReadsEarlierRotatingScans)
        GTEST_SKIP() << "this MRPT cannot read its own " << file
                     << ": rotating scans of one row are NOT TESTED with it";
    const auto scan = std::dynamic_pointer_cast<mrpt::obs::CObservationRotatingScan>(
        test::readScans(file, 1)[0].scan);
    ASSERT_TRUE(scan);
    const auto returns = readReturns(*scan, {});
    ASSERT_TRUE(returns);
    EXPECT_TRUE(returns->planar);
    EXPECT_EQ(returns->hits.size() + returns->noReturnCount, 361u);
    ASSERT_GT(returns->hits.size(), 100u);
    std::size_t hit = 0;
    for (int c = 0; c < 361; ++c) {
        const double range = scan->rangeImage(0, c) * scan->rangeResolution;
        if (range < scan->minRange || range > scan->maxRange) continue;
        const double angle = -M_PI / 2 + M_PI * c / 360;
        EXPECT_NEAR(returns->hits[hit].x(), range * std::cos(angle), 1e-4);
        EXPECT_NEAR(returns->hits[hit].y(), range * std::sin(angle), 1e-4);
        ++hit;
    }
    EXPECT_EQ(hit, returns->hits.size());
}

TEST(RotatingScan, SeveralRowsWithoutVerticalAnglesAreNotSupported) {
    mrpt::obs::CObservationRotatingScan scan;
    scan.rowCount = 16;
    scan.columnCount = 10;
    scan.rangeImage.setSize(16, 10);
    EXPECT_FALSE(canReadReturns(scan));
    EXPECT_FALSE(readReturns(scan, {}));
}

TEST(RotatingScan, RangesOfOneRow) {
    mrpt::obs::CObservationRotatingScan scan;
    scan.rowCount = 1;
    scan.columnCount = 5;
    scan.rangeImage.setSize(1, 5);
    scan.rangeResolution = 0.01;
    scan.minRange = 0.5;
    scan.maxRange = 20;
    scan.startAzimuth = -M_PI / 2;
    scan.azimuthSpan = M_PI;
    const std::array<std::uint16_t, 5> ranges = {100, 0, 200, 10, 3000};  // [cm]
    for (int c = 0; c < 5; ++c) scan.rangeImage(0, c) = ranges[static_cast<std::size_t>(c)];
    EXPECT_TRUE(canReadReturns(scan));
    const auto returns = readReturns(scan, {});
    ASSERT_TRUE(returns);
    EXPECT_TRUE(returns->planar);
    ASSERT_EQ(returns->hits.size(), 2u) << "1 m and 2 m; the others are out of the limits";
    EXPECT_NEAR((returns->hits[0] - Eigen::Vector3f(0, -1, 0)).norm(), 0, 1e-6);
    EXPECT_NEAR((returns->hits[1] - Eigen::Vector3f(2, 0, 0)).norm(), 0, 1e-6);
    EXPECT_EQ(returns->noReturnCount, 3u);
}

TEST(RotatingScan, NothingWithoutPointsAndRanges) {
    for (const int rows : {1, 16}) {
        mrpt::obs::CObservationRotatingScan scan;
        scan.rowCount = static_cast<std::uint16_t>(rows);
        scan.columnCount = 10;
        EXPECT_FALSE(canReadReturns(scan)) << rows;
        EXPECT_FALSE(readReturns(scan, {})) << rows;
    }
}

TEST(Returns, OtherClassesAreNotSupported) {
    const mrpt::obs::CObservationOdometry odometry;
    EXPECT_FALSE(canReadReturns(odometry));
    EXPECT_FALSE(readReturns(odometry, {}));
}

TEST(ToRays, TwoDimensionsProjectTheHeightBand) {
    const auto scan = test::randomCloud(2000, 3);
    const auto returns = readReturns(*scan, {});
    TInsertionOptions options;
    options.heightBandMin = 1.0;
    options.heightBandMax = 2.5;
    TInsertionReport report;
    const auto rays =
        toRays(*returns, test::someRobotPose(), CellGeometry<2>(0.1), options, report);
    const auto T = test::someRobotPose() + test::someSensorPose();
    std::vector<Point<2>> expected, hits;
    std::size_t crossing = 0;
    for (const auto& p : returns->hits) {
        mrpt::math::TPoint3D q;
        T.composePoint(p.x(), p.y(), p.z(), q.x, q.y, q.z);
        if (q.z >= 1.0 && q.z <= 2.5) expected.emplace_back(q.x, q.y);
        crossing += std::max(q.z, T.z()) >= 1.0 && std::min(q.z, T.z()) <= 2.5;
    }
    for (std::size_t i = 0; i < rays.size(); ++i)
        if (rays.kind(i) == RayEnd::hit) hits.push_back(rays.end(i));
    ASSERT_EQ(hits.size(), expected.size());
    for (std::size_t i = 0; i < hits.size(); ++i)
        EXPECT_LT((hits[i] - expected[i]).norm(), 1e-9);
    // What ends outside the band clears what it crosses inside.
    EXPECT_EQ(rays.size(), crossing);
    EXPECT_EQ(report.outOfHeightBand, 2000 - hits.size());
    EXPECT_GT(hits.size(), 200u);
    EXPECT_GT(rays.size(), hits.size());

    // In 3D, returns outside the band are left out.
    TInsertionReport report3;
    const auto rays3 =
        toRays(*returns, test::someRobotPose(), CellGeometry<3>(0.1), options, report3);
    EXPECT_EQ(rays3.size(), hits.size());
    EXPECT_EQ(report3.outOfHeightBand, 2000 - hits.size());
}

TEST(ToRays, PlanarScansKeepToTheHeightBand) {
    const auto planar = readReturns(*test::planarScan(), {});  // 0.4 m up
    TInsertionOptions options;
    for (const bool isInside : {true, false}) {
        options.heightBandMin = isInside ? 0.3 : 100;
        options.heightBandMax = isInside ? 0.5 : 101;
        TInsertionReport report;
        const std::size_t rays = isInside ? 45 : 0;
        EXPECT_EQ(toRays(*planar, {}, CellGeometry<2>(0.1), options, report).size(), rays);
        EXPECT_EQ(toRays(*planar, {}, CellGeometry<3>(0.1), options, report).size(), rays);
        EXPECT_EQ(report.outOfHeightBand, isInside ? 0u : 90u);
    }
}

TEST(ToRays, RangesAreLimitedAndBadPointsCounted) {
    SensorReturns returns;
    returns.hits = {
        {1, 0, 0},     {std::nanf(""), 0, 0}, {0, std::numeric_limits<float>::infinity(), 0},
        {0.05f, 0, 0}, {1e6f, 0, 0},          {8, 0, 0}};
    TInsertionOptions options;
    options.minrange = 0.1;
    options.maxrange = 5;
    TInsertionReport report;
    const auto rays = toRays(returns, {}, CellGeometry<3>(0.1), options, report);
    ASSERT_EQ(rays.size(), 3u);
    EXPECT_EQ(rays.kind(0), RayEnd::hit);
    EXPECT_EQ(rays.kind(1), RayEnd::noReturn);
    EXPECT_EQ(rays.kind(2), RayEnd::noReturn);
    EXPECT_NEAR(rays.end(2).x(), 5, 1e-12);
    EXPECT_EQ(report.skipped.notFinite, 2u);
    EXPECT_EQ(report.skipped.tooNear, 1u);
    options.maxrange = -1;
    TInsertionReport unlimited;
    toRays(returns, {}, CellGeometry<3>(0.1), options, unlimited);
    EXPECT_EQ(unlimited.skipped.outOfRange, 1u);
}

// The map's window is around the common origin, and a first ray that starts where no cell is
// must not cost the others.
TEST(ToRays, TheCommonOriginIsTheSensorNotWhereTheFirstRayEntersTheBand) {
    const Eigen::Vector3f near(-1, 0, -1.5f), grazing(50000, 0, -1.001f);
    TInsertionOptions options;
    options.heightBandMin = 0;
    options.heightBandMax = 1;
    const mrpt::poses::CPose3D pose(0.5, 0, 2, 0, 0, 0);
    for (const bool nearFirst : {true, false}) {
        SensorReturns returns;
        returns.hits = {near, grazing};
        if (!nearFirst) std::swap(returns.hits[0], returns.hits[1]);
        const auto expectSensor = [&](const RayBundle<2>& rays,
                                      const TInsertionReport& report) {
            EXPECT_EQ(rays.commonOrigin(), Point<2>(0.5, 0));
            ASSERT_EQ(rays.size(), 1u);
            EXPECT_NEAR(rays.end(0).x(), -0.5, 1e-6);
            EXPECT_EQ(report.skipped.outOfRange, 1u);
        };
        TInsertionReport report, along;
        expectSensor(toRays(returns, pose, CellGeometry<2>(0.1), options, report), report);
        expectSensor(toRaysAlong(
                         returns, {},
                         [&](mrpt::Clock::time_point) {
                             return std::optional<mrpt::poses::CPose3D>(pose);
                         },
                         CellGeometry<2>(0.1), options, along),
                     along);
    }
}

TEST(ToRays, ASensorOutOfRangeIsAnError) {
    SensorReturns returns;
    returns.hits = {{1, 0, 0}};
    TInsertionReport report;
    const mrpt::poses::CPose3D far(1e7, 0, 0, 0, 0, 0);
    EXPECT_THROW(toRays(returns, far, CellGeometry<3>(0.1), {}, report), std::invalid_argument);
}

}  // namespace
}  // namespace superray
