// SPDX-License-Identifier: BSD-3-Clause
// Depth and range images to points: against the forward camera model, written
// out here, and against MRPT's own unprojection.

#include <superray/maps/observation_rays.h>

#include <iostream>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::img::TCamera;
using mrpt::obs::CObservation3DRangeScan;

CObservation3DRangeScan::Ptr makeImage(bool depth) {
    auto scan = CObservation3DRangeScan::Create();
    scan->hasRangeImage = true;
    scan->range_is_depth = depth;
    scan->rangeUnits = 0.001f;
    scan->maxRange = 5;
    scan->sensorPose = test::someSensorPose();
    scan->cameraParams.ncols = 64;
    scan->cameraParams.nrows = 48;
    scan->cameraParams.setIntrinsicParamsFromValues(50, 52, 31.3, 24.1);
    scan->rangeImage.setSize(48, 64);
    for (int r = 0; r < 48; ++r)
        for (int c = 0; c < 64; ++c)
            scan->rangeImage(r, c) = (r + c) % 10 == 0
                                         ? std::uint16_t{0}
                                         : static_cast<std::uint16_t>(1000 + 37 * r + 11 * c);
    return scan;
}

/// Pixel of a point in the sensor frame by the forward model.
Eigen::Vector2d project(const Eigen::Vector3d& p, const TCamera& camera) {
    // Camera frame: x right, y down, z forward.
    const double x = -p.y() / p.x(), y = -p.z() / p.x();
    double xd = x, yd = y;
    const auto& d = camera.dist;
    const double r2 = x * x + y * y;
    if (camera.distortion == mrpt::img::DistortionModel::plumb_bob) {
        const double radial = (1 + d[0] * r2 + d[1] * r2 * r2 + d[4] * r2 * r2 * r2);
        xd = x * radial + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x);
        yd = y * radial + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y;
    } else if (camera.distortion == mrpt::img::DistortionModel::kannala_brandt) {
        const double theta = std::atan2(std::hypot(p.y(), p.z()), p.x());
        const double t2 = theta * theta;
        const double td = theta * (1 + d[0] * t2 + d[1] * t2 * t2 + d[4] * t2 * t2 * t2 +
                                   d[5] * t2 * t2 * t2 * t2);
        const double side = std::hypot(p.y(), p.z());
        xd = side > 0 ? -p.y() / side * td : 0;
        yd = side > 0 ? -p.z() / side * td : 0;
    }
    return {camera.fx() * xd + camera.cx(), camera.fy() * yd + camera.cy()};
}

void expectAllPixelsProjectBack(const CObservation3DRangeScan& scan) {
    const auto returns = readReturns(scan, {});
    ASSERT_TRUE(returns);
    std::size_t i = 0, zeros = 0;
    for (int r = 0; r < scan.rangeImage.rows(); ++r)
        for (int c = 0; c < scan.rangeImage.cols(); ++c) {
            if (scan.rangeImage(r, c) == 0) {
                ++zeros;
                continue;
            }
            ASSERT_LT(i, returns->hits.size());
            const Eigen::Vector3d p = returns->hits[i++].cast<double>();
            const auto pixel = project(p, scan.cameraParams);
            EXPECT_NEAR(pixel.x(), c, 1e-3);
            EXPECT_NEAR(pixel.y(), r, 1e-3);
            const double metres = scan.rangeImage(r, c) * 0.001;
            EXPECT_NEAR(scan.range_is_depth ? p.x() : p.norm(), metres, 1e-5);
        }
    EXPECT_EQ(i, returns->hits.size());
    EXPECT_EQ(returns->noReturnCount, zeros);
    EXPECT_GT(zeros, 100u);
    EXPECT_TRUE(returns->noReturns.empty());
    EXPECT_FALSE(returns->planar);
}

TEST(RangeImage, DepthAndRangePinhole) {
    expectAllPixelsProjectBack(*makeImage(true));
    expectAllPixelsProjectBack(*makeImage(false));
}

TEST(RangeImage, PlumbBobDistortionIsUndone) {
    for (const bool depth : {true, false}) {
        auto scan = makeImage(depth);
        scan->cameraParams.setDistortionPlumbBob(-0.2, 0.05, 0.003, -0.002, 0.01);
        expectAllPixelsProjectBack(*scan);
    }
}

TEST(RangeImage, FisheyeIsUndone) {
    for (const bool depth : {true, false}) {
        auto scan = makeImage(depth);
        scan->cameraParams.setDistortionKannalaBrandt(0.02, -0.004, 0.001, 0.0002);
        expectAllPixelsProjectBack(*scan);
    }
}

TEST(RangeImage, NoReturnRaysHaveTheAskedOrTheSensorsRange) {
    const auto scan = makeImage(true);
    for (const auto& [asked, expected] : {std::pair{0.0, 5.0f}, std::pair{2.5, 2.5f}}) {
        const auto returns = readReturns(*scan, {1, true, asked});
        ASSERT_TRUE(returns);
        EXPECT_EQ(returns->noReturns.size(), returns->noReturnCount);
        ASSERT_GT(returns->noReturns.size(), 100u);
        for (const auto& p : returns->noReturns) EXPECT_NEAR(p.norm(), expected, 1e-5);
        // The first zero pixel is (0, 0).
        const auto pixel =
            project(returns->noReturns.front().cast<double>(), scan->cameraParams);
        EXPECT_NEAR(pixel.x(), 0, 1e-3);
        EXPECT_NEAR(pixel.y(), 0, 1e-3);
    }
}

TEST(RangeImage, DecimationTakesOneOfN) {
    const auto returns = readReturns(*makeImage(true), {3, false, 0});
    ASSERT_TRUE(returns);
    EXPECT_EQ(returns->hits.size() + returns->noReturnCount, 48u * 64u / 3u);
}

TEST(RangeImage, RobotAndSensorPoseActOnOriginAndPoints) {
    const auto scan = makeImage(true);
    const auto returns = readReturns(*scan, {});
    TInsertionReport report;
    const CellGeometry<3> geometry(0.05);
    const auto rays = toRays(*returns, test::someRobotPose(), geometry, {}, report);
    ASSERT_EQ(rays.size(), returns->hits.size());
    const auto T = test::someRobotPose() + test::someSensorPose();
    EXPECT_NEAR((rays.commonOrigin() - Point<3>(T.x(), T.y(), T.z())).norm(), 0, 1e-12);
    EXPECT_TRUE(rays.hasCommonOrigin());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const auto& p = returns->hits[i];
        mrpt::math::TPoint3D q;
        T.composePoint(p.x(), p.y(), p.z(), q.x, q.y, q.z);
        EXPECT_NEAR((rays.end(i) - Point<3>(q.x, q.y, q.z)).norm(), 0, 1e-9);
        EXPECT_EQ(rays.kind(i), RayEnd::hit);
    }
}

TEST(RangeImage, Points3DAreUsedWithoutAnImage) {
    auto scan = CObservation3DRangeScan::Create();
    scan->hasPoints3D = true;
    scan->points3D_x = {1, 0, 2, std::nanf("")};
    scan->points3D_y = {0.5f, 0, -1, 0};
    scan->points3D_z = {0.25f, 0, 1, 0};
    const auto returns = readReturns(*scan, {});
    ASSERT_TRUE(returns);
    ASSERT_EQ(returns->hits.size(), 3u);
    EXPECT_EQ(returns->noReturnCount, 1u) << "(0, 0, 0) means no return";
    EXPECT_EQ(returns->hits[1], Eigen::Vector3f(2, -1, 1));
    TInsertionReport report;
    EXPECT_EQ(toRays(*returns, {}, CellGeometry<3>(0.1), {}, report).size(), 2u);
    EXPECT_EQ(report.skipped.notFinite, 1u);
    scan->points3D_z.pop_back();
    EXPECT_THROW(readReturns(*scan, {}), std::invalid_argument);
}

TEST(RangeImage, BadCamerasAreRejectedWithTheirValues) {
    auto scan = makeImage(true);
    scan->cameraParams.ncols = 640;
    EXPECT_CONTAINS(test::messageOf([&] { readReturns(*scan, {}); }), "640");
    scan->cameraParams.ncols = 64;
    scan->cameraParams.setIntrinsicParamsFromValues(0, 52, 31.3, 24.1);
    EXPECT_CONTAINS(test::messageOf([&] { readReturns(*scan, {}); }), "fx = 0");
    for (const float units : {0.0f, -1.0f, INFINITY, NAN}) {
        scan = makeImage(true);
        scan->rangeUnits = units;
        EXPECT_CONTAINS(test::messageOf([&] { readReturns(*scan, {}); }),
                        "rangeUnits = " + std::to_string(units));
    }
    scan->hasRangeImage = false;
    EXPECT_FALSE(readReturns(*scan, {}));
    EXPECT_FALSE(canReadReturns(*scan));
}

TEST(RangeImage, RealImageAgreesWithMrptAndIsLeftAlone) {
    const auto file = test::mrptDataset("tests_rgbd.rawlog");
    SUPERRAY_SKIP_WITHOUT(file);
    const auto scans = test::readScans(file, 1);
    ASSERT_EQ(scans.size(), 1u);
    const auto scan = std::dynamic_pointer_cast<CObservation3DRangeScan>(scans[0].scan);
    ASSERT_TRUE(scan);
    const auto imageBefore = scan->rangeImage;
    const auto pointsBefore = scan->points3D_x;
    const auto returns = readReturns(*scan, {});
    ASSERT_TRUE(returns);
    EXPECT_EQ(scan->rangeImage, imageBefore);
    EXPECT_EQ(scan->points3D_x, pointsBefore);
    EXPECT_TRUE(scan->hasPoints3D);

    mrpt::maps::CSimplePointsMap mrptPoints;
    CObservation3DRangeScan copy = *scan;
    copy.unprojectInto(mrptPoints);
    ASSERT_EQ(mrptPoints.size(), returns->hits.size());
    EXPECT_EQ(mrptPoints.size(), 273225u);
    double worst = 0;
    for (std::size_t i = 0; i < mrptPoints.size(); ++i) {
        float x = 0, y = 0, z = 0;
        mrptPoints.getPoint(i, x, y, z);
        worst = std::max<double>(worst, (returns->hits[i] - Eigen::Vector3f(x, y, z)).norm() /
                                            returns->hits[i].norm());
    }
    std::cout << "largest relative difference from MRPT's unprojection: " << worst << "\n";
    EXPECT_LT(worst, 1e-4);
}

TEST(RangeImage, ExternalImagesAreUnloadedAfterUse) {
    const test::TempFolder folder;
    auto scan = makeImage(true);
    const auto expected = readReturns(*scan, {});
    scan->rangeImage_convertToExternalStorage(folder.file("image.bin"), "");
    scan->unload();
    ASSERT_TRUE(scan->rangeImage_isExternallyStored());
    ASSERT_EQ(scan->rangeImage.size(), 0);
    const auto returns = readReturns(*scan, {});
    ASSERT_TRUE(returns);
    EXPECT_EQ(returns->hits, expected->hits);
    EXPECT_EQ(scan->rangeImage.size(), 0) << "unloaded again";
    scan->load();
    EXPECT_TRUE(readReturns(*scan, {}));
    EXPECT_GT(scan->rangeImage.size(), 0) << "it was loaded before, so it stays";
}

}  // namespace
}  // namespace superray
