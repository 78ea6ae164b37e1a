// SPDX-License-Identifier: BSD-3-Clause
// Raw Velodyne packets: against MRPT's own conversion where that makes a
// point, at full density, and against hand-made packets.

#include <superray/maps/observation_rays.h>

#include <Eigen/Geometry>
#include <cstring>
#include <iostream>

#include "maps/test_scans.h"

namespace superray {
namespace {

using Scan = mrpt::obs::CObservationVelodyneScan;
using Packet = Scan::TVelodyneRawPacket;

void put16(std::uint8_t* at, unsigned value) {
    at[0] = static_cast<std::uint8_t>(value & 255);
    at[1] = static_cast<std::uint8_t>(value >> 8);
}

/// A packet by its bytes, as in the manual: 12 blocks of header, azimuth and 32
/// returns (distance, intensity), a time stamp, mode and model.
template <class Header, class Azimuth, class Distance>
Packet makePacket(Header header, Azimuth azimuth, Distance distance, std::uint8_t mode,
                  std::uint8_t model) {
    std::array<std::uint8_t, Scan::PACKET_SIZE> bytes{};
    for (int b = 0; b < 12; ++b) {
        std::uint8_t* block = bytes.data() + 100 * b;
        put16(block, header(b));
        put16(block + 2, azimuth(b));
        for (int i = 0; i < 32; ++i) put16(block + 4 + 3 * i, distance(b, i));
    }
    bytes[1204] = mode;
    bytes[1205] = model;
    Packet packet;
    static_assert(sizeof packet == Scan::PACKET_SIZE);
    std::memcpy(static_cast<void*>(&packet), bytes.data(), bytes.size());
    return packet;
}

/// Largest distance from an MRPT point to our nearest one, over its range.
double worstRelativeError(const Scan& scan, const SensorReturns& ours, bool ordered) {
    const auto& pc = scan.point_cloud;
    double worst = 0;
    std::size_t j = 0;
    for (std::size_t i = 0; i < pc.size(); ++i) {
        const Eigen::Vector3f p(pc.x[i], pc.y[i], pc.z[i]);
        double best = 1e9;
        if (ordered) {
            // Both go through the packets in order: search forwards only.
            for (std::size_t k = j; k < std::min(j + 64, ours.hits.size()); ++k) {
                const double d = (ours.hits[k] - p).norm() / p.norm();
                if (d >= best) continue;
                best = d;
                if (d < 1e-3) {
                    j = k + 1;
                    break;
                }
            }
        } else {
            for (const auto& q : ours.hits)
                best = std::min<double>(best, (q - p).norm() / p.norm());
        }
        worst = std::max(worst, best);
    }
    return worst;
}

TEST(Velodyne, RealVlp16ScanHasFullDensity) {
    const auto file = test::mrptDataset("test_velodyne_VLP16.rawlog");
    SUPERRAY_SKIP_WITHOUT(file);
    const auto scans = test::readScans(file, 1);
    ASSERT_EQ(scans.size(), 1u);
    auto scan = std::dynamic_pointer_cast<Scan>(scans[0].scan);
    ASSERT_TRUE(scan);

    const auto returns = readReturns(*scan, {1, true, 0});
    ASSERT_TRUE(returns);
    EXPECT_EQ(returns->hits.size(), 22591u);
    EXPECT_EQ(returns->noReturnCount, 6209u);
    EXPECT_EQ(returns->hits.size() + returns->noReturnCount, 75u * 12u * 32u);
    EXPECT_EQ(returns->noReturns.size(), 6209u);
    EXPECT_EQ(scan->point_cloud.size(), 0u) << "the observation is left alone";

    scan->generatePointCloud();
    ASSERT_EQ(scan->point_cloud.size(), 11305u);
    // MRPT rounds azimuths to 0.01 degree and looks sines up in a table whose
    // step is 2 pi / 35999: together up to 2.7e-4 rad.
    const double worst = worstRelativeError(*scan, *returns, true);
    std::cout << "VLP-16: largest relative difference from MRPT's points " << worst << "\n";
    EXPECT_LT(worst, 3e-4);

    // With the raw packets there, the half-density cloud is not used.
    EXPECT_EQ(readReturns(*scan, {})->hits.size(), 22591u);
    scan->scan_packets.clear();
    EXPECT_EQ(readReturns(*scan, {})->hits.size(), 11305u);
}

TEST(Velodyne, RangeLimitsOfTheObservationAreHonoured) {
    const auto file = test::mrptDataset("test_velodyne_VLP16.rawlog");
    SUPERRAY_SKIP_WITHOUT(file);
    auto scan = std::dynamic_pointer_cast<Scan>(test::readScans(file, 1)[0].scan);
    scan->minRange = 3;
    scan->maxRange = 1000;
    std::size_t beyond = 0;
    const auto all = readReturns(*scan, {});
    for (const auto& p : all->hits) beyond += p.norm() > 10;
    scan->maxRange = 10;
    const auto returns = readReturns(*scan, {1, true, 0});
    ASSERT_GT(returns->hits.size(), 1000u);
    for (const auto& p : returns->hits) {
        EXPECT_GE(p.norm(), 3 - 1e-4);
        EXPECT_LE(p.norm(), 10 + 1e-4);
    }
    // What is too near tells nothing; what is too far, that there is free space.
    EXPECT_EQ(returns->noReturns.size(), 6209u + beyond);
    EXPECT_EQ(returns->hits.size() + returns->noReturnCount, 75u * 12u * 32u);
    for (const auto& p : returns->noReturns) EXPECT_NEAR(p.norm(), 10, 1e-4);
}

TEST(Velodyne, Vlp16AzimuthsAdvanceWithinABlock) {
    Scan scan;
    scan.calibration = mrpt::obs::VelodyneCalibration::LoadDefaultCalibration("VLP16");
    // 0.40 degree per block, through the wrap at 360 degrees; 10 m everywhere.
    scan.scan_packets.push_back(makePacket(
        [](int) { return 0xEEFFu; }, [](int b) { return unsigned(35800 + 40 * b) % 36000u; },
        [](int, int) { return 5000u; }, 0x37, 0x22));
    const auto returns = readReturns(scan, {});
    ASSERT_EQ(returns->hits.size(), 12u * 32u);
    for (int b = 0; b < 12; ++b)
        for (int i = 0; i < 32; ++i) {
            const auto& p = returns->hits[static_cast<std::size_t>(32 * b + i)];
            const double microseconds = (i / 16) * 55.296 + (i % 16) * 2.304;
            const double clockwise =
                (358.0 + 0.4 * b + 0.4 * microseconds / 110.592) * M_PI / 180;
            const int laser = i % 16;  // -15, 1, -13, 3, ... 15 degrees
            const double elevation = (laser % 2 == 0 ? laser - 15 : laser) * M_PI / 180;
            const Eigen::Vector3d expected(10 * std::cos(elevation) * std::cos(clockwise),
                                           -10 * std::cos(elevation) * std::sin(clockwise),
                                           10 * std::sin(elevation));
            EXPECT_LT((p.cast<double>() - expected).norm(), 1e-4) << b << " " << i;
        }
}

TEST(Velodyne, DualReturnsAreTakenOnce) {
    Scan scan;
    scan.calibration = mrpt::obs::VelodyneCalibration::LoadDefaultCalibration("VLP16");
    // Pairs of blocks; the second differs from the first for lasers below 8.
    scan.scan_packets.push_back(makePacket(
        [](int) { return 0xEEFFu; }, [](int b) { return unsigned(1000 + 40 * (b / 2)); },
        [](int b, int i) { return i == 31 ? 0u : (b % 2 == 1 && i < 8 ? 4000u : 5000u); }, 0x39,
        0x22));
    const auto returns = readReturns(scan, {1, true, 0});
    EXPECT_EQ(returns->hits.size(), 6u * (31u + 8u));
    EXPECT_EQ(returns->noReturns.size(), 6u);
    scan.generatePointCloud();
    EXPECT_LT(worstRelativeError(scan, *returns, false), 3e-4);
}

TEST(Velodyne, Hdl32AgreesWithMrpt) {
    Scan scan;
    scan.calibration = mrpt::obs::VelodyneCalibration::LoadDefaultCalibration("HDL32");
    for (int k = 0; k < 5; ++k)
        scan.scan_packets.push_back(makePacket(
            [](int) { return 0xEEFFu; }, [&](int b) { return unsigned(200 * k + 16 * b); },
            [&](int b, int i) { return unsigned(2000 + 300 * k + 50 * b + 40 * i); }, 0x37,
            0x21));
    const auto returns = readReturns(scan, {});
    ASSERT_EQ(returns->hits.size(), 5u * 12u * 32u);
    scan.generatePointCloud();
    ASSERT_GT(scan.point_cloud.size(), 500u);
    EXPECT_LT(worstRelativeError(scan, *returns, false), 3e-4);

    // Without calibration, the model number tells which one to take.
    scan.calibration.laser_corrections.clear();
    EXPECT_EQ(readReturns(scan, {})->hits, returns->hits);
}

TEST(Velodyne, Hdl64UsesBothBanksAndTheLaserCalibration) {
    Scan scan;
    for (int i = 0; i < 64; ++i) {
        mrpt::obs::VelodyneCalibration::PerLaserCalib laser;
        const double elevation = (2.0 - 0.4 * i) * M_PI / 180;
        laser.verticalCorrection = elevation * 180 / M_PI;
        laser.sinVertCorrection = std::sin(elevation);
        laser.cosVertCorrection = std::cos(elevation);
        laser.distanceCorrection = 0.01 * i;
        laser.verticalOffsetCorrection = 0.2;
        laser.horizontalOffsetCorrection = i % 2 ? 0.026 : -0.026;
        scan.calibration.laser_corrections.push_back(laser);
    }
    scan.scan_packets.push_back(
        makePacket([](int b) { return b % 2 ? 0xDDFFu : 0xEEFFu; },
                   [](int b) { return unsigned(9000 + 18 * (b / 2)); },
                   [](int b, int i) { return unsigned(3000 + 100 * b + 10 * i); }, 0x37, 0));
    const auto returns = readReturns(scan, {});
    ASSERT_EQ(returns->hits.size(), 12u * 32u);
    scan.generatePointCloud();
    ASSERT_GT(scan.point_cloud.size(), 100u);
    const double worst = worstRelativeError(scan, *returns, false);
    std::cout << "HDL-64: largest relative difference from MRPT's points " << worst << "\n";
    EXPECT_LT(worst, 5e-4);

    // A laser that looks 5 degrees less clockwise than the block says. MRPT
    // leaves this correction out, so its points must be turned.
    for (auto& laser : scan.calibration.laser_corrections) laser.azimuthCorrection = 5;
    auto turned = *readReturns(scan, {});
    const Eigen::AngleAxisf back(static_cast<float>(-5 * M_PI / 180), Eigen::Vector3f::UnitZ());
    for (auto& p : turned.hits) p = back * p;
    scan.generatePointCloud();
    EXPECT_LT(worstRelativeError(scan, turned, false), 5e-4);
}

TEST(Velodyne, DamagedPacketsAndUnknownModels) {
    Scan scan;
    scan.calibration = mrpt::obs::VelodyneCalibration::LoadDefaultCalibration("VLP16");
    scan.scan_packets.push_back(makePacket([](int b) { return b == 3 ? 0x1234u : 0xEEFFu; },
                                           [](int b) { return unsigned(40 * b); },
                                           [](int, int) { return 5000u; }, 0x37, 0x22));
    EXPECT_EQ(readReturns(scan, {})->hits.size(), 3u * 32u) << "blocks before the damage";
    scan.calibration.laser_corrections.resize(7);
    EXPECT_CONTAINS(test::messageOf([&] { readReturns(scan, {}); }), "7");
    EXPECT_FALSE(readReturns(Scan(), {}));
}

// A recording stores x, y and z with a size each.
TEST(Velodyne, PointsWithoutAYOrZAreRefused) {
    for (int axis = 0; axis < 3; ++axis) {
        Scan scan;
        scan.point_cloud.x = scan.point_cloud.y = scan.point_cloud.z = {1, 2, 3};
        EXPECT_EQ(readReturns(scan, {})->hits.size(), 3u);
        std::vector<float>* const axes[] = {&scan.point_cloud.x, &scan.point_cloud.y,
                                            &scan.point_cloud.z};
        axes[axis]->pop_back();
        EXPECT_CONTAINS(test::messageOf([&] { readReturns(scan, {}); }),
                        std::string("2 ") + "xyz"[axis]);
    }
}

// As for 2D scans: many programs leave the range at 0, or at -1.
TEST(Velodyne, AMaximumRangeOfZeroIsNoLimit) {
    Scan scan;
    scan.calibration = mrpt::obs::VelodyneCalibration::LoadDefaultCalibration("VLP16");
    scan.scan_packets.push_back(makePacket([](int) { return 0xEEFFu; },
                                           [](int b) { return unsigned(40 * b); },
                                           [](int, int) { return 5000u; }, 0x37, 0x22));
    for (const double maxRange : {-1.0, 0.0, 100.0}) {
        scan.maxRange = maxRange;
        EXPECT_EQ(readReturns(scan, {})->hits.size(), 12u * 32u) << maxRange;
    }
}

}  // namespace
}  // namespace superray
