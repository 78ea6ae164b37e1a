// SPDX-License-Identifier: BSD-3-Clause
// Network captures of a Velodyne, written by Scapy (tests/data/formats), against the same
// packets in a rawlog.

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <superray/eval/input_error.h>

#include <array>
#include <filesystem>

#include "eval/sources/format_samples.h"

namespace superray {
namespace {

using namespace test;
using mrpt::obs::CObservationVelodyneScan;

const std::string kDataset = "/usr/share/mrpt/datasets/test_velodyne_VLP16.rawlog";

constexpr std::size_t kFileHeader = 24, kRecordHeader = 16;
/// Of plain.pcap: 14 bytes of Ethernet, 20 of IP, 8 of UDP, 1206 of the Velodyne.
constexpr std::size_t kRecord = kRecordHeader + 1248, kPayload = kRecordHeader + 42;

const std::string& plain() {
    static const std::string bytes = readWholeFile(sample("velodyne/plain.pcap"));
    return bytes;
}

class VelodyneCapture : public testing::Test {
 protected:
    Built built(const std::string& bytes, ScanSourceOptions options = {}) {
        options.poses = PoseOrigin::file;
        options.posesFile = sample("poses.tum");
        return build(folder_.write("a.pcap", bytes), options);
    }
    std::string errorOf(const std::string& bytes, const ScanSourceOptions& options = {}) {
        return messageOf<InputError>([&] { built(bytes, options); });
    }
    /// plain.pcap with another value at an offset in the record of a packet.
    static std::string changed(std::size_t packet, std::size_t at, char value) {
        std::string bytes = plain();
        bytes.at(kFileHeader + packet * kRecord + at) = value;
        return bytes;
    }
    /// The same, without the checksum that tells it.
    static std::string changedPayload(std::size_t packet, std::size_t at, char value) {
        std::string bytes = changed(packet, kPayload + at, value);
        bytes[kFileHeader + packet * kRecord + kPayload - 2] = 0;
        bytes[kFileHeader + packet * kRecord + kPayload - 1] = 0;
        return bytes;
    }

    TempFolder folder_;
};

TEST_F(VelodyneCapture, givesTheMapOfTheRawlog) {
    const auto captured = built(plain());
    EXPECT_EQ(captured.scans, 3u);
    expectPart(captured.poses, "3, 0.0 to 1.0 s");
    // Another byte order, nanoseconds, VLAN tags, other packets between.
    const auto tagged = build(sample("velodyne/tagged.pcap"), withPoses(sample("poses.tum")));
    EXPECT_EQ(tagged.digest, captured.digest);
    EXPECT_EQ(tagged.scans, 3u);

    if (!std::filesystem::exists(kDataset))
        GTEST_SKIP() << "RECORDING ABSENT: " << kDataset << "; NOT TESTED";
    ScanSourceOptions fixed;
    fixed.poses = PoseOrigin::fixed;
    const auto shipped = openScanSource(kDataset, fixed)->next();
    ASSERT_TRUE(shipped);
    const auto& revolution =
        dynamic_cast<const CObservationVelodyneScan&>(*shipped->observation);
    Objects objects;
    for (std::size_t i = 0; i < 3; ++i) {
        auto scan = std::make_shared<CObservationVelodyneScan>(revolution);
        scan->timestamp = at(1000 + 0.5 * static_cast<double>(i));
        scan->sensorPose = CPose3D();
        scan->scan_packets.clear();
        for (std::size_t k = 0; k < 4; ++k)
            scan->scan_packets.push_back(revolution.scan_packets.at(20 * k + i));
        objects.push_back(
            makePose(1000 + 0.5 * static_cast<double>(i), samplePose(static_cast<int>(i))));
        objects.push_back(scan);
    }
    EXPECT_EQ(build(writeRawlog(folder_ / "a.rawlog", objects)).digest, captured.digest);
}

TEST_F(VelodyneCapture, aScanEndsWhereTheAzimuthPassesZeroOrTheRecordingPauses) {
    EXPECT_EQ(built(plain()).scans, 3u);
    // The third packet and those after it of the first revolution, 0.2 s later.
    std::string paused = plain();
    for (const std::size_t packet : {2, 3}) {
        std::string later("\x40\x0d\x03\x00", 4);  // 200000 us
        later[0] = static_cast<char>(0x40 + packet);
        paused.replace(kFileHeader + packet * kRecord + 4, 4, later);
    }
    EXPECT_EQ(built(paused).scans, 4u);
}

TEST_F(VelodyneCapture, needsPosesAndStampsScansWithTheTimeOfCapture) {
    const auto file = folder_.write("a.pcap", plain());
    expectPart(messageOf<InputError>([&] { build(file); }), "give a poses file (--poses FILE)");
    const auto poses = folder_.write("late.tum", "2000 0 0 0 0 0 0 1\n2001 0 0 0 0 0 0 1\n");
    expectPart(messageOf<InputError>([&] { build(file, withPoses(poses)); }),
               "1000.000 to 1001.000 s");
}

TEST_F(VelodyneCapture, otherCapturesAreNamedWithTheWayOut) {
    expectPart(errorOf("\x0a\x0d\x0d\x0a" + std::string(60, '\0')), "editcap -F pcap");
    expectPart(errorOf(std::string(60, 'x')), "is not a network capture");
    expectPart(errorOf(plain().substr(0, kFileHeader - 1)), "is not a network capture");
    std::string bluetooth = plain();
    bluetooth[20] = '\x68';
    expectPart(errorOf(bluetooth), "link type 104");
    expectPart(errorOf(plain().substr(0, kFileHeader)), "holds no packets of a Velodyne");
    // Models whose angles nobody has told.
    const std::size_t modelByte = 1205;
    expectPart(errorOf(changedPayload(0, modelByte, '\x28')), "model number 40");
    expectPart(errorOf(changedPayload(5, 1, '\xdd')),
               "packet 6 of a Velodyne is of an HDL-64E");
}

TEST_F(VelodyneCapture, twoSensorsAreNotMixed) {
    // The second half of the packets from another address, without a checksum.
    std::string two = plain();
    for (std::size_t packet = 6; packet < 12; ++packet) {
        const std::size_t start = kFileHeader + packet * kRecord + kRecordHeader;
        two[start + 14 + 15] = '\xca';  // the last byte of the sender's address, 202
        two[start + 40] = two[start + 41] = 0;
    }
    const auto message = errorOf(two);
    expectPart(message, "VELODYNE_192.168.1.201_2368, VELODYNE_192.168.1.202_2368");
    expectPart(message, "--sensor");
    ScanSourceOptions options;
    options.sensorLabel = "VELODYNE_192.168.1.202_2368";
    EXPECT_EQ(built(two, options).scans, 2u);
    options.sensorLabel = "VELODYNE_192.168.1.203_2368";
    expectPart(errorOf(two, options), "is not among them");
}

TEST_F(VelodyneCapture, damageIsSeen) {
    // Any byte of the returns, by the checksum, where others are right.
    expectPart(errorOf(changed(4, kPayload + 510, '\x55')),
               "packet 5 of a Velodyne is damaged: its UDP checksum is wrong");
    // Without checksums, by the blocks.
    expectPart(errorOf(changedPayload(4, 3, '\xff')), "packet 5 of a Velodyne is damaged");
    expectPart(errorOf(changedPayload(4, 100, '\x12')), "block 1");
    // A record's header.
    expectPart(errorOf(changed(3, 7, '\x7f')), "its time has a fraction of");
    expectPart(errorOf(changed(3, 10, '\x20')), "is damaged: ");
}

TEST_F(VelodyneCapture, modelsThatChangeAndTimesThatGoBackAreRefused) {
    const std::size_t modelByte = 1205;
    expectPart(errorOf(changedPayload(7, modelByte, '\x21')),
               "packet 8 of a Velodyne is of another model");
    std::string reversed = plain().substr(0, kFileHeader);
    for (std::size_t packet = 12; packet-- > 0;)
        reversed += plain().substr(kFileHeader + packet * kRecord, kRecord);
    expectPart(errorOf(reversed), "packet 2 of a Velodyne is earlier than the one before it");
    expectPart(errorOf(reversed), "reordercap");
    // Packets of one time are none.
    std::string same = plain();
    same.replace(kFileHeader + kRecord, 8, same.substr(kFileHeader, 8));
    EXPECT_EQ(built(same).digest, built(plain()).digest);
}

TEST_F(VelodyneCapture, wrongChecksumsOfAllPacketsAreLeftToTheAdapter) {
    std::string offloaded = plain();
    for (std::size_t packet = 0; packet < 12; ++packet)
        offloaded[kFileHeader + packet * kRecord + kPayload - 2] ^= '\x55';
    EXPECT_EQ(built(offloaded).digest, built(plain()).digest);
}

TEST_F(VelodyneCapture, thatEndEarlyAreRefusedOrUsedAsAsked) {
    const std::string cut = plain().substr(0, kFileHeader + 9 * kRecord + 700);
    expectPart(errorOf(cut), "packet 10, at byte ");
    expectPart(errorOf(cut), "--accept-truncated");
    ScanSourceOptions options;
    options.truncation = Truncation::accept;
    EXPECT_EQ(built(cut, options).scans, 3u);
    options = withPoses(sample("poses.tum"));
    options.truncation = Truncation::accept;
    const auto source = openScanSource(folder_.write("a.pcap", cut), options);
    expectPart(source->warning(), "the file ends within it");
    // As tcpdump -s 96 writes them.
    std::string snapped = plain().substr(0, kFileHeader);
    snapped += plain().substr(kFileHeader, 8) + std::string("\x60\0\0\0", 4) +
               plain().substr(kFileHeader + 12, 4 + 96);
    expectPart(errorOf(snapped), "was cut to 54 of 1206 bytes");
}

}  // namespace
}  // namespace superray
