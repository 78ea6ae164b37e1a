// SPDX-License-Identifier: BSD-3-Clause
// Recordings whose data are in files of their own, in each layout that MRPT knows: the
// map of the data inside, or an error that names the file.

#include <gtest/gtest.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/math/CMatrixF.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <superray/eval/input_error.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/compressed_input.h>
#include <sys/stat.h>

#include "eval/recorded_scans.h"
#include "eval/sources/broken_bytes.h"
#include "eval/sources/limited_process.h"
#include "eval/sources/map_of_recording.h"
#include "eval/temp_folder.h"
#include "gzip_bytes.h"

namespace superray {
namespace {

using namespace test;
using mrpt::obs::CObservation3DRangeScan;
using mrpt::obs::CObservationPointCloud;
using mrpt::poses::CPose3D;

CObservation3DRangeScan::Ptr depthImage() {
    auto scan = CObservation3DRangeScan::Create();
    scan->timestamp = at(0);
    scan->sensorLabel = "CAM";
    scan->hasRangeImage = true;
    scan->rangeUnits = 0.001f;
    scan->maxRange = 5;
    scan->cameraParams.ncols = 16;
    scan->cameraParams.nrows = 12;
    scan->cameraParams.setIntrinsicParamsFromValues(15, 15, 7.5, 5.5);
    scan->rangeImage.setSize(12, 16);
    for (int i = 0; i < 12 * 16; ++i)
        scan->rangeImage.data()[i] = static_cast<std::uint16_t>(1000 + 12 * i);
    return scan;
}

CObservation3DRangeScan::Ptr cameraPoints() {
    auto scan = CObservation3DRangeScan::Create();
    scan->timestamp = at(0);
    scan->sensorLabel = "CAM";
    scan->hasPoints3D = true;
    scan->points3D_idxs_x.resize(40);
    scan->points3D_idxs_y.resize(40);
    for (int i = 0; i < 40; ++i) {
        scan->points3D_x.push_back(2);
        scan->points3D_y.push_back(0.05f * static_cast<float>(i) - 1);
        scan->points3D_z.push_back(0.01f * static_cast<float>(i));
    }
    return scan;
}

template <class Object>
std::string serialized(const Object& object) {
    mrpt::io::CMemoryStream memory;
    mrpt::serialization::archiveFrom(memory) << object;
    return {static_cast<const char*>(memory.getRawBufferData()),
            static_cast<std::size_t>(memory.getTotalBytesCount())};
}

/// A scan with its data inside, and as it is with them in a file of its own.
struct Sample {
    std::string file;
    mrpt::obs::CObservation::Ptr inside, outside;
    std::string bytes;
    bool packed = false;
};

class ExternalFiles : public testing::Test {
 protected:
    ExternalFiles() {
        for (const bool text : {false, true}) {
            CObservation3DRangeScan::EXTERNALS_AS_TEXT(text);
            const std::string end = text ? ".txt" : ".bin";
            const auto image = depthImage();
            image->rangeImage_convertToExternalStorage("image" + end, folder_ / "");
            add("image" + end, depthImage(), image, readWholeFile(folder_ / ("image" + end)));
            const auto points = cameraPoints();
            points->points3D_convertToExternalStorage("points" + end, folder_ / "");
            add("points" + end, cameraPoints(), points,
                readWholeFile(folder_ / ("points" + end)));
        }
        CObservation3DRangeScan::EXTERNALS_AS_TEXT(false);
        addImageOfOldMrpt();
        addClouds();
    }

    void addImageOfOldMrpt() {
        const auto inside = depthImage();
        mrpt::math::CMatrixF metres(12, 16);
        for (int i = 0; i < 12 * 16; ++i)
            metres.data()[i] = 0.001f * static_cast<float>(inside->rangeImage.data()[i]);
        const auto outside = depthImage();
        outside->rangeImage_convertToExternalStorage("old.bin", folder_ / "");
        add("old.bin", inside, outside, gzip(serialized(metres)));
    }

    void addClouds() {
        using Format = CObservationPointCloud::ExternalStorageFormat;
        const auto inside = makeCloud(0, 1);
        std::string kitti, text;
        for (std::size_t i = 0; i < inside->pointcloud->size(); ++i) {
            float p[4] = {0, 0, 0, 0.5f};
            inside->pointcloud->getPoint(i, p[0], p[1], p[2]);
            kitti.append(reinterpret_cast<const char*>(p), sizeof p);
            for (int k = 0; k < 3; ++k) {
                char number[32];
                std::snprintf(number, sizeof number, "%.9g ", static_cast<double>(p[k]));
                text += number;
            }
            text += '\n';
        }
        const auto outside = [&](const char* file, Format format) {
            auto scan = makeCloud(0, 1);
            scan->pointcloud.reset();
            scan->setAsExternalStorage(file, format);
            return scan;
        };
        add("cloud.bin", inside, outside("cloud.bin", Format::MRPT_Serialization),
            gzip(serialized(*inside->pointcloud)));
        add("kitti.bin", inside, outside("kitti.bin", Format::KittiBinFile), kitti);
        add("cloud.txt", inside, outside("cloud.txt", Format::PlainTextFile), text);
    }

    void add(const std::string& file, const mrpt::obs::CObservation::Ptr& inside,
             const mrpt::obs::CObservation::Ptr& outside, const std::string& bytes) {
        const bool packed = bytes.compare(0, 2, "\x1f\x8b") == 0;
        samples_.push_back({file, inside, outside, bytes, packed});
        writeRawlog(folder_ / (file + ".rawlog"), {makePose(0, CPose3D()), outside});
    }

    std::string digestOf(const std::string& rawlog) const {
        CSuperRayGridMap3D map(0.1);
        buildInto(map, rawlog);
        return map.digest();
    }
    std::string digest(const Sample& sample, const std::string& bytes) const {
        folder_.write(sample.file, bytes);
        return digestOf(folder_ / (sample.file + ".rawlog"));
    }
    std::string expected(const Sample& sample) const {
        return digestOf(
            writeRawlog(folder_ / "inside.rawlog", {makePose(0, CPose3D()), sample.inside}));
    }
    /// Of the sample with another file.
    std::string error(const Sample& sample, const std::string& bytes) const {
        return messageOf<InputError>([&] { digest(sample, bytes); });
    }

    TempFolder folder_;
    std::vector<Sample> samples_;
};

TEST_F(ExternalFiles, GiveTheMapOfTheDataInside) {
    ASSERT_EQ(samples_.size(), 8u);
    for (const Sample& s : samples_) EXPECT_EQ(digest(s, s.bytes), expected(s)) << s.file;
}

TEST_F(ExternalFiles, CutOrLongerOnesAreRefused) {
    int cuts = 0;
    for (const Sample& s : samples_) {
        for (std::size_t i = 0; i < 60; ++i) {
            const std::size_t length = s.bytes.size() * i / 60;
            // Nothing tells between the points of the one, the lines of the other.
            if (s.file == "kitti.bin" && length % 16 == 0) continue;
            if (s.file == "cloud.txt" && (length == 0 || s.bytes[length - 1] == '\n')) continue;
            if (s.file == "points.txt" && length > 0 && s.bytes[length - 1] == '\n') continue;
            const auto why = error(s, s.bytes.substr(0, length));
            EXPECT_NE(why.find(s.file), std::string::npos) << length << ": " << why;
            EXPECT_EQ(why.find('\n'), std::string::npos) << why;
            ++cuts;
        }
        if (s.packed)
            expectPart(error(s, s.bytes + gzip("more")), s.file + ": external file of a scan");
        expectPart(error(s, s.bytes + "more"), s.file + ": external file of a scan");
    }
    EXPECT_GT(cuts, 400);
}

std::string unpacked(const std::string& path) {
    CompressedInput file(path);
    std::string bytes(1 << 16, '\0');
    bytes.resize(file.Read(bytes.data(), bytes.size()));
    return bytes;
}

TEST_F(ExternalFiles, ChangedBytesDoNoHarm) {
    const auto [count, seed] = orOfEnvironment({600, 31});
    std::mt19937 random(seed);
    std::vector<std::string> whole;
    for (const Sample& s : samples_) whole.push_back(expected(s));
    std::vector<std::string> broken;
    std::vector<bool> sealed;  // changed after its check sum was made
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        const Sample& s = samples_[i % samples_.size()];
        sealed.push_back(s.packed && i % 3 == 0);
        folder_.write("whole", s.bytes);
        broken.push_back(s.packed && !sealed.back()
                             ? gzip(mutated(unpacked(folder_ / "whole"), random))
                             : mutated(s.bytes, random));
    }
    enum : int { kSame, kOther, kRefused };
    const auto outcome = [&](std::size_t i) -> int {
        const std::size_t n = i % samples_.size();
        try {
            return digest(samples_[n], broken[i]) == whole[n] ? kSame : kOther;
        } catch (const InputError&) {
            return kRefused;
        }
    };
    std::vector<LimitedRun> runs;
    constexpr std::size_t kTogether = 50;
    while (runs.size() < broken.size()) {
        const std::size_t first = runs.size();
        const auto some = runLimited(std::min(kTogether, broken.size() - first),
                                     [&](std::size_t i) { return outcome(first + i); });
        runs.insert(runs.end(), some.begin(), some.end());
    }
    int refused = 0;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const Sample& s = samples_[i % samples_.size()];
        EXPECT_EQ(runs[i].harm, "") << s.file << keepBroken(s.file, broken[i]);
        if (sealed[i] && broken[i].compare(0, 2, "\x1f\x8b") == 0) {
            EXPECT_NE(runs[i].result, kOther) << s.file << keepBroken(s.file, broken[i]);
        }
        refused += runs[i].result == kRefused;
    }
    EXPECT_GT(refused, count / 3);
}

/// Without a check sum: only the sizes tell.
TEST_F(ExternalFiles, WildSizesAreComparedWithTheBytes) {
    const std::string wild = "\xF0\xFF\xFF\xFF";
    const std::string image = std::string("\x60\xEA\0\0\x60\xEA\0\0", 8) + std::string(100, 0);
    auto cloud = serialized(*makeCloud(0, 1)->pointcloud);
    cloud.replace(cloud.find("CSimplePointsMap") + 17, 4, wild);
    auto matrix = serialized(mrpt::math::CMatrixF(12, 16));
    matrix.replace(matrix.find("CMatrixF") + 9, 8, wild + wild);
    const std::string bytes[] = {image, wild + std::string(100, 0), cloud, matrix};
    const std::string rules[] = {"60000 x 60000", "it ends after",
                                 "it claims 4294967280 points", "4294967280 x 4294967280"};
    const std::size_t of[] = {0, 1, 5, 4};
    const auto runs = runLimited(4, [&](std::size_t i) {
        const auto why = error(samples_[of[i]], bytes[i]);
        if (why.find(rules[i]) == std::string::npos) std::fprintf(stderr, "%s\n", why.c_str());
        return why.find(rules[i]) != std::string::npos ? 1 : 0;
    });
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(runs[i].harm, "") << i;
        EXPECT_EQ(runs[i].result, 1) << rules[i];
    }
}

TEST_F(ExternalFiles, WhatIsNoFileIsRefusedByName) {
    for (const Sample& s : samples_) {
        const auto path = folder_ / s.file;
        const auto refused = [&] {
            const auto why =
                messageOf<InputError>([&] { digestOf(folder_ / (s.file + ".rawlog")); });
            expectPart(why, path + ": is not a file");
        };
        std::filesystem::remove(path);
        ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
        refused();
        std::filesystem::remove(path);
        std::filesystem::create_directory(path);
        refused();
        std::filesystem::remove(path);
        std::filesystem::create_symlink("/dev/zero", path);
        refused();
        std::filesystem::remove(path);
    }
}

TEST_F(ExternalFiles, TextOfOtherShapeIsRefused) {
    const Sample& image = samples_[2];
    ASSERT_EQ(image.file, "image.txt");
    expectPart(error(image, "1 2 3\n4 5\n"), "line 2 has 2 numbers");
    expectPart(error(image, "1 2\nx 4\n"), "line 2 holds what is no number");
    expectPart(error(image, "1 2\n3 4\n"), "range image of 2 x 2 pixels");
    const Sample& points = samples_[3];
    ASSERT_EQ(points.file, "points.txt");
    expectPart(error(points, "1 2\n3 4\n"), "3 columns, or 3 rows");
    expectPart(error(points, "1 2 3\n1 2 3\n1 2 3\n"), "not both");
    EXPECT_EQ(digest(points, "1 1\n2 3\n4 5\n"), digest(points, "1 2 4\n1 3 5\n"));
}

}  // namespace
}  // namespace superray
