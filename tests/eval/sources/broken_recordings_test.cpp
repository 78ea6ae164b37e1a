// SPDX-License-Identifier: BSD-3-Clause
// Recordings with changed, missing and added bytes: an error or a map, never a crash,
// and neither gigabytes nor minutes.

#include <gtest/gtest.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <superray/eval/input_error.h>
#include <superray/eval/scan_source.h>
#include <superray/maps/CSuperRayGridMap3D.h>

#include <array>
#include <cstdlib>
#include <cstring>

#include "eval/insert_scans.h"
#include "eval/recorded_scans.h"
#include "eval/sources/broken_bytes.h"
#include "eval/sources/limited_process.h"
#include "eval/temp_folder.h"
#include "gzip_bytes.h"

namespace superray {
namespace {

using namespace test;
using mrpt::poses::CPose3D;

template <class Scan>
typename Scan::Ptr emptyScan(double seconds, const char* label) {
    auto scan = Scan::Create();
    scan->timestamp = at(seconds);
    scan->sensorLabel = label;
    return scan;
}

mrpt::obs::CObservation2DRangeScan::Ptr laserScan(double seconds) {
    auto scan = emptyScan<mrpt::obs::CObservation2DRangeScan>(seconds, "LASER");
    scan->aperture = 3;
    scan->maxRange = 20;
    scan->resizeScanAndAssign(31, 3.0f, true);
    return scan;
}

mrpt::obs::CObservation3DRangeScan::Ptr depthImage(double seconds) {
    auto scan = emptyScan<mrpt::obs::CObservation3DRangeScan>(seconds, "DEPTH");
    scan->hasRangeImage = true;
    scan->rangeImage_setSize(6, 8);
    scan->rangeImage.fill(1500);
    scan->rangeUnits = 0.001f;
    scan->cameraParams.ncols = 8;
    scan->cameraParams.nrows = 6;
    scan->cameraParams.setIntrinsicParamsFromValues(8, 8, 4, 3);
    return scan;
}

mrpt::obs::CObservationRotatingScan::Ptr rotatingScan(double seconds) {
    auto scan = emptyScan<mrpt::obs::CObservationRotatingScan>(seconds, "ROTATING");
    scan->rowCount = 2;
    scan->columnCount = 12;
    scan->rangeResolution = 0.01;
    scan->rangeImage.setSize(2, 12);
    scan->rangeImage.fill(300);
    scan->azimuthSpan = 2 * M_PI;
    scan->minRange = 0.1;
    scan->maxRange = 50;
    return scan;
}

mrpt::obs::CObservationVelodyneScan::Ptr velodyneScan(double seconds) {
    using Scan = mrpt::obs::CObservationVelodyneScan;
    auto scan = emptyScan<Scan>(seconds, "VELODYNE");
    scan->calibration = mrpt::obs::VelodyneCalibration::LoadDefaultCalibration("VLP16");
    Scan::TVelodyneRawPacket packet;
    std::array<std::uint8_t, sizeof packet> bytes{};
    for (std::size_t i = 0; i < Scan::BLOCKS_PER_PACKET; ++i) {
        const std::size_t block = i * sizeof(Scan::raw_block_t);
        bytes[block] = 0xFF;
        bytes[block + 1] = 0xEE;
        for (std::size_t r = 0; r < Scan::SCANS_PER_BLOCK; ++r) bytes[block + 5 + 3 * r] = 4;
    }
    std::memcpy(static_cast<void*>(&packet), bytes.data(), bytes.size());
    packet.laser_return_mode = Scan::RETMODE_STRONGEST;
    packet.velodyne_model_ID = 0x22;
    scan->scan_packets = {packet};
    return scan;
}

mrpt::obs::CActionCollection::Ptr movement(double seconds) {
    auto actions = mrpt::obs::CActionCollection::Create();
    mrpt::obs::CActionRobotMovement2D action;
    action.timestamp = at(seconds);
    action.computeFromOdometry(mrpt::poses::CPose2D(0.1, 0, 0.01), {});
    actions->insert(action);
    return actions;
}

std::string bytesOf(const Objects& objects) {
    mrpt::io::CMemoryStream memory;
    auto archive = mrpt::serialization::archiveFrom(memory);
    for (const auto& object : objects) archive << *object;
    return {static_cast<const char*>(memory.getRawBufferData()),
            static_cast<std::size_t>(memory.getTotalBytesCount())};
}

struct Sample {
    std::string extension, bytes;
};

/// A recording of each kind of observation, one of pairs, and a simplemap.
std::vector<Sample> samples() {
    std::vector<Sample> result;
    const Objects scans[] = {{makeCloud(1, 1, "LIDAR", 12)},
                             {laserScan(1)},
                             {depthImage(1)},
                             {rotatingScan(1)},
                             {velodyneScan(1)}};
    for (const auto& scan : scans) {
        Objects objects = {makePose(1, CPose3D(0.1, 0.2, 0, 0.1, 0, 0))};
        objects.push_back(scan[0]);
        objects.push_back(makeOdometry(2, mrpt::poses::CPose2D(1, 0, 0)));
        result.push_back({".rawlog", bytesOf(objects)});
    }
    auto frame = mrpt::obs::CSensoryFrame::Create();
    frame->insert(laserScan(1));
    frame->insert(makeCloud(1, 2, "LIDAR", 5));
    result.push_back({".rawlog", bytesOf({movement(1), frame})});
    auto map = mrpt::maps::CSimpleMap::Create();
    map->insert(mrpt::poses::CPose3DPDFGaussian::Create(CPose3D(1, 2, 0)), frame);
    result.push_back({".simplemap", bytesOf({map})});
    return result;
}

/// What our programs do with a recording.
void mapRecording(const std::string& path) {
    ScanSourceOptions options;
    insertWhatCanBe(*openScanSource(path, options));
}

/// What becomes of a recording.
enum : int { kMapped = 0, kRefused = 1, kOtherError = 2 };

int outcomeOf(const std::string& path) {
    try {
        mapRecording(path);
    } catch (const InputError&) {
        return kRefused;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return kOtherError;
    }
    return kMapped;
}

TEST(BrokenRecordings, SamplesAreWhole) {
    const TempFolder folder;
    for (const auto& sample : samples()) {
        const auto file = folder.write("a" + sample.extension, sample.bytes);
        EXPECT_EQ(outcomeOf(file), kMapped);
        const auto zipped = folder.write("b" + sample.extension + ".gz", gzip(sample.bytes));
        EXPECT_EQ(outcomeOf(zipped), kMapped);
    }
}

/// \param kind 0: not compressed; 1: changed before it is packed; 2: and after
Sample brokenSample(const Sample& sample, std::size_t kind, std::mt19937& random) {
    const std::string bytes = mutated(sample.bytes, random);
    if (kind == 0) return {sample.extension, bytes};
    return {sample.extension + ".gz",
            kind == 1 ? gzip(bytes) : mutated(gzip(sample.bytes), random)};
}

TEST(BrokenRecordings, MutatedOnesDoNoHarm) {
    const auto [count, seed] = orOfEnvironment({700, 20});
    const auto all = samples();
    const TempFolder folder;
    std::mt19937 random(seed);
    int mapped = 0, refused = 0;
    constexpr std::size_t kTogether = 20;
    for (int done = 0; done < count;) {
        std::vector<Sample> broken(kTogether);
        for (std::size_t n = 0; n < kTogether; ++n)
            broken[n] = brokenSample(all[(static_cast<std::size_t>(done) + n) % all.size()],
                                     n % 3, random);
        const auto runs = runLimited(kTogether, [&](std::size_t n) {
            return outcomeOf(folder.write("m" + broken[n].extension, broken[n].bytes));
        });
        for (std::size_t n = 0; n < kTogether; ++n, ++done) {
            const LimitedRun& run = runs[n];
            if (!run.harm.empty() || run.result == kOtherError)
                ADD_FAILURE() << run.harm << " (result " << run.result << "): "
                              << keepBroken(std::to_string(seed) + "-" + std::to_string(done) +
                                                broken[n].extension,
                                            broken[n].bytes);
            mapped += run.result == kMapped;
            refused += run.result == kRefused;
        }
    }
    EXPECT_GT(mapped, count / 20);
    EXPECT_GT(refused, count / 4);
    std::printf("%d mapped, %d refused\n", mapped, refused);
}

}  // namespace
}  // namespace superray
