// SPDX-License-Identifier: BSD-3-Clause
// Recordings that MRPT 2.15 wrote, zstd inside: the same maps with every MRPT.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>
#include <superray/eval/map_build.h>
#include <superray/eval/scan_source.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/gzip_output.h>
#include <zstd.h>

#include <random>

#include "eval/recorded_scans.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;

const std::string kData = std::string(SUPERRAY_TEST_DATA_DIR) + "/";

/// Digest of the map of an input, and its scans.
std::pair<std::string, std::uint64_t> mapOf(const std::string& path) {
    ScanSources sources;
    sources.push_back(openScanSource(path));
    CSuperRayGridMap3D map(0.25);
    map.insertionOptions.setPolicy(UpdatePolicy::everyRay);
    const auto report = buildMap(sources, map, std::numeric_limits<std::uint64_t>::max(),
                                 [](const BuildProgress&) {});
    EXPECT_EQ(report.unusable, 0u);
    return {map.digest(), report.scans};
}

std::string decompressed(const std::string& path) {
    const auto bytes = readWholeFile(path);
    std::string plain(std::size_t{1} << 21, '\0');
    ZSTD_DCtx* context = ZSTD_createDCtx();
    ZSTD_outBuffer out{plain.data(), plain.size(), 0};
    ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
    EXPECT_EQ(ZSTD_decompressStream(context, &out, &in), 0u);
    ZSTD_freeDCtx(context);
    plain.resize(out.pos);
    return plain;
}

TEST(NewerRecordings, HaveTheSameMapsWithEveryMrpt) {
    EXPECT_EQ(
        mapOf(kData + "mrpt_2_15.rawlog"),
        std::make_pair(std::string("40e5d237a2bd779735fa83af8c92cc01"), std::uint64_t{162}));
    EXPECT_EQ(
        mapOf(kData + "mrpt_2_15.simplemap"),
        std::make_pair(std::string("9aaaa58816a22648a559a6a8bff9cff0"), std::uint64_t{8}));
    EXPECT_EQ(
        mapOf(kData + "mrpt_2_15_external.rawlog"),
        std::make_pair(std::string("2684926f3da748eb5525ad696d7d46a8"), std::uint64_t{6}));
}

TEST(NewerRecordings, AreReadUncompressedToo) {
    const TempFolder folder;
    const auto path = folder.write("plain.rawlog", decompressed(kData + "mrpt_2_15.rawlog"));
    EXPECT_EQ(mapOf(path), mapOf(kData + "mrpt_2_15.rawlog"));
}

TEST(NewerRecordings, ScansBeforeATruncationAreWhole) {
    const TempFolder folder;
    const auto whole = readWholeFile(kData + "mrpt_2_15.rawlog");
    std::vector<Scan> all;
    const auto source = openScanSource(kData + "mrpt_2_15.rawlog");
    while (auto scan = source->next()) all.push_back(*scan);
    ASSERT_EQ(all.size(), 162u);
    ScanSourceOptions accept;
    accept.truncation = Truncation::accept;
    int refused = 0, accepted = 0;
    for (std::size_t length = 1; length < whole.size(); length += 83) {
        const auto path = folder.write("cut.rawlog", whole.substr(0, length));
        const auto message = messageOf<InputError>([&] { openScanSource(path); });
        ASSERT_NE(message.find("truncated"), std::string::npos) << message;
        ++refused;
        if (message.find("scans before it: 0") != std::string::npos) continue;
        EXPECT_NE(message.find("--accept-truncated"), std::string::npos) << message;
        const auto cut = openScanSource(path, accept);
        std::size_t scans = 0;
        while (const auto scan = cut->next()) {
            ASSERT_LT(scans, all.size());
            EXPECT_EQ(scan->timestamp, all[scans].timestamp);
            EXPECT_EQ(scan->T_map_robot.asTPose(), all[scans].T_map_robot.asTPose());
            ++scans;
        }
        EXPECT_EQ(scans, cut->total());
        EXPECT_NE(cut->warning().find("scans before it: "), std::string::npos);
        ++accepted;
    }
    EXPECT_GT(refused, 300);
    EXPECT_GT(accepted, 10);
}

TEST(NewerRecordings, ChangedBytesNeverCrash) {
    const TempFolder folder;
    const auto whole = readWholeFile(kData + "mrpt_2_15.simplemap");
    std::mt19937 random(11);
    int told = 0;
    for (int i = 0; i < 300; ++i) {
        auto changed = whole;
        changed[random() % changed.size()] ^= static_cast<char>(1u << random() % 8);
        const auto path = folder.write("changed.simplemap", changed);
        const auto message = messageOf<InputError>([&] { openScanSource(path); });
        told += message != "no exception";
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
    EXPECT_GT(told, 20);
}

TEST(NewerRecordings, ATruncatedExternalFileIsNamed) {
    const TempFolder folder;
    const std::string cloud = "mrpt_2_15_external_Images/pc_LIDAR_1700000001.000000000.bin";
    std::filesystem::copy(kData, folder / "", std::filesystem::copy_options::recursive);
    const auto bytes = readWholeFile(kData + cloud);
    folder.write(cloud, bytes.substr(0, bytes.size() / 2));
    const auto message =
        messageOf<std::exception>([&] { mapOf(folder / "mrpt_2_15_external.rawlog"); });
    EXPECT_NE(message.find("pc_LIDAR_1700000001"), std::string::npos) << message;
    EXPECT_NE(message.find("truncated"), std::string::npos) << message;
}

TEST(NewerRecordings, WhatWeWriteIsGzip) {
    const TempFolder folder;
    writeGzip(*makeCloud(1, 1), folder / "cloud");
    EXPECT_EQ(readWholeFile(folder / "cloud").substr(0, 2), "\x1f\x8b");
    EXPECT_THROW(writeGzip(*makeCloud(1, 1), folder / "no/such/folder"), std::runtime_error);
}

}  // namespace
}  // namespace superray
