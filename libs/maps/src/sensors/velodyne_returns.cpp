// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/system/datetime.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <stdexcept>

#include "sensors/sensor_returns.h"

namespace superray {
namespace {

using Scan = mrpt::obs::CObservationVelodyneScan;
using Packet = Scan::TVelodyneRawPacket;
using mrpt::obs::VelodyneCalibration;
using LaserCalibration = VelodyneCalibration::PerLaserCalib;

/// A little-endian number in a packet. MRPT's accessors bind references to members of
/// packed structures, most of which are not aligned.
template <class Number>
Number numberAt(const void* structure, std::size_t offset) {
    const auto* bytes = static_cast<const unsigned char*>(structure) + offset;
    Number value = 0;
    for (std::size_t i = sizeof value; i-- > 0;)
        value = static_cast<Number>(value << 8 | bytes[i]);
    return value;
}

std::uint16_t headerOf(const Scan::raw_block_t& block) {
    return numberAt<std::uint16_t>(&block, 0);
}
std::uint16_t rotationOf(const Scan::raw_block_t& block) {
    return numberAt<std::uint16_t>(&block, 2);
}
std::uint16_t distanceOf(const Scan::laser_return_t& laser) {
    return numberAt<std::uint16_t>(&laser, 0);
}
/// From the full hour [us].
std::uint32_t timeOf(const Packet& packet) {
    return numberAt<std::uint32_t>(&packet, sizeof packet.blocks);
}

constexpr double kMetresPerUnit = 0.002;
constexpr double kRadiansPerUnit = M_PI / 18000;  // azimuths come in 0.01 degree

/// Firing times of a sensor within a block of 32 returns [us], from the
/// manufacturer's manuals.
struct Timing {
    double returnPeriod;  ///< from one laser to the next
    double firingPeriod;  ///< from one firing of all lasers to the next
    double blockPeriod;   ///< from one block to the next (of another azimuth)
};
constexpr Timing kVlp16{2.304, 55.296, 110.592};  // two firings of 16 per block
constexpr Timing kHdl32{1.152, 46.08, 46.08};     // one firing of 32 per block
/// HDL-64E: two blocks (upper and lower bank) share an azimuth; the manual has
/// no rule to interpolate, and the calibration is made without. 1.33 million
/// points per second make 48 us for the pair.
constexpr Timing kHdl64{0, 0, 48};

struct Model {
    const std::vector<LaserCalibration>* lasers;
    Timing timing;
};

Model modelOf(const Scan& scan) {
    const auto* lasers = &scan.calibration.laser_corrections;
    if (lasers->empty() && !scan.scan_packets.empty()) {
        const int id = scan.scan_packets.front().velodyne_model_ID;
        if (id == 0x22)
            lasers = &VelodyneCalibration::LoadDefaultCalibration("VLP16").laser_corrections;
        if (id == 0x21)
            lasers = &VelodyneCalibration::LoadDefaultCalibration("HDL32").laser_corrections;
    }
    switch (lasers->size()) {
        case 16:
            return {lasers, kVlp16};
        case 32:
            return {lasers, kHdl32};
        case 64:
            return {lasers, kHdl64};
        default:
            break;
    }
    std::ostringstream message;
    message << "Velodyne scan \"" << scan.sensorLabel << "\": calibration of " << lasers->size()
            << " lasers; must have 16, 32 or 64";
    throw std::invalid_argument(message.str());
}

/// Median advance of the azimuth per block [0.01 degree]: the speed of rotation,
/// undisturbed by a lost packet.
double azimuthPerBlock(const Packet& packet, int blocksPerAzimuth) {
    std::array<int, Scan::BLOCKS_PER_PACKET> advance{};
    const int n = Scan::BLOCKS_PER_PACKET - blocksPerAzimuth;
    for (int b = 0; b < n; ++b) {
        const int turn = Scan::ROTATION_MAX_UNITS;
        const int difference =
            rotationOf(packet.blocks[b + blocksPerAzimuth]) - rotationOf(packet.blocks[b]);
        advance[static_cast<std::size_t>(b)] = ((difference % turn) + turn) % turn;
    }
    std::nth_element(advance.begin(), advance.begin() + n / 2, advance.begin() + n);
    return advance[static_cast<std::size_t>(n / 2)];
}

/// Time since the first packet of a scan [us]. Packets count from the full hour.
double microsecondsSince(const Packet& first, const Packet& packet) {
    constexpr std::int64_t kHour = 3600000000;
    const auto elapsed = std::int64_t{timeOf(packet)} - std::int64_t{timeOf(first)};
    return static_cast<double>(elapsed < 0 ? elapsed + kHour : elapsed);
}

/// The manufacturer's model: the beam of a laser leaves the axis with an offset
/// in height and sideways. Velodyne's y is MRPT's x, its x is MRPT's -y.
struct Beam {
    const LaserCalibration& laser;
    double sine, cosine;  // of the azimuth, clockwise seen from above

    Beam(const LaserCalibration& l, double azimuth)
        : laser(l), sine(std::sin(azimuth)), cosine(std::cos(azimuth)) {}

    Eigen::Vector3f at(double distance) const {
        const double horizontal = distance * laser.cosVertCorrection +
                                  laser.verticalOffsetCorrection * laser.sinVertCorrection;
        const double side = laser.horizontalOffsetCorrection;
        return {static_cast<float>(horizontal * cosine + side * sine),
                static_cast<float>(-(horizontal * sine - side * cosine)),
                static_cast<float>(distance * laser.sinVertCorrection +
                                   laser.verticalOffsetCorrection)};
    }
    Eigen::Vector3f direction() const {
        return {static_cast<float>(laser.cosVertCorrection * cosine),
                static_cast<float>(-laser.cosVertCorrection * sine),
                static_cast<float>(laser.sinVertCorrection)};
    }
};

class PacketReader {
 public:
    PacketReader(const Scan& scan, ReturnCollector& to)
        : scan_(scan), model_(modelOf(scan)), to_(to) {}

    void read(const Packet& packet) const {
        const bool dual = packet.laser_return_mode == Scan::RETMODE_DUAL;
        // Dual return: two blocks per azimuth. HDL-64E: the two banks.
        const bool banks = model_.lasers->size() == 64;
        const int blocksPerAzimuth = dual || banks ? 2 : 1;
        const double turn = azimuthPerBlock(packet, blocksPerAzimuth);
        const double packetTime = microsecondsSince(scan_.scan_packets.front(), packet);
        for (int b = 0; b < Scan::BLOCKS_PER_PACKET; ++b) {
            const auto& block = packet.blocks[b];
            const bool lower = headerOf(block) == Scan::LOWER_BANK;
            // As MRPT: damaged data end the packet.
            if (headerOf(block) != Scan::UPPER_BANK && !(banks && lower)) return;
            // The second block of a dual return repeats those that were single.
            const auto* twin = dual && !banks && b % 2 == 1 ? &packet.blocks[b - 1] : nullptr;
            const double blockTime =
                packetTime + model_.timing.blockPeriod * (b / blocksPerAzimuth);
            readBlock(block, twin, lower ? 32 : 0, turn, blockTime);
        }
    }

 private:
    void readBlock(const Scan::raw_block_t& block, const Scan::raw_block_t* twin,
                   std::size_t firstLaser, double turn, double blockTime) const {
        const std::size_t lasers = std::min<std::size_t>(model_.lasers->size(), 32);
        const Timing& timing = model_.timing;
        for (std::size_t i = 0; i < Scan::SCANS_PER_BLOCK; ++i) {
            const auto raw = distanceOf(block.laser_returns[i]);
            if (twin && (raw == 0 || raw == distanceOf(twin->laser_returns[i]))) continue;
            if (!to_.next()) continue;
            const LaserCalibration& laser = (*model_.lasers)[firstLaser + i % lasers];
            const double time = timing.firingPeriod * static_cast<double>(i / lasers) +
                                timing.returnPeriod * static_cast<double>(i % lasers);
            const double units = rotationOf(block) + turn * time / timing.blockPeriod;
            // The correction is in degrees. (MRPT 2.5.8 leaves it out.)
            const double azimuth = (units - 100 * laser.azimuthCorrection) * kRadiansPerUnit;
            const double distance = raw * kMetresPerUnit + laser.distanceCorrection;
            const Beam beam(laser, azimuth);
            to_.measuredAt((blockTime + time) * 1e-6);
            if (raw == 0) {
                to_.noReturn(beam.direction());
            } else if (distance < scan_.minRange) {
                to_.invalid();
            } else if (scan_.maxRange > 0 && distance > scan_.maxRange) {  // else: not known
                to_.noReturn(beam.direction());
            } else {
                to_.hit(beam.at(distance), static_cast<float>(distance));
            }
        }
    }

    const Scan& scan_;
    Model model_;
    ReturnCollector& to_;
};

}  // namespace

std::optional<SensorReturns> read(const Scan& scan, const ReturnOptions& options) {
    SensorReturns out;
    out.sensorOnRobot = scan.sensorPose;
    ReturnCollector to(out, options, scan.maxRange);
    if (!scan.scan_packets.empty()) {
        out.hits.reserve(scan.scan_packets.size() * Scan::SCANS_PER_PACKET);
        const PacketReader reader(scan, to);
        for (const auto& packet : scan.scan_packets) reader.read(packet);
    } else if (scan.point_cloud.size() > 0) {
        out.hits.reserve(scan.point_cloud.size());
        const auto& cloud = scan.point_cloud;
        const bool timed = cloud.timestamp.size() == cloud.x.size();
        collectPoints(cloud.x, cloud.y, cloud.z, to, [&](std::size_t i) {
            return timed ? mrpt::system::timeDifference(scan.timestamp, cloud.timestamp[i]) : 0;
        });
    } else {
        return std::nullopt;
    }
    return out;
}

}  // namespace superray
