// SPDX-License-Identifier: BSD-3-Clause
// Particle filters of MRPT >= 2.14 ask one map for likelihoods and matches from several
// threads, about one and the same observation. Made to be run under TSan, too.

#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/serialization/CArchive.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayPointsMap.h>
#include <superray/maps/observation_rays.h>

#include <atomic>
#include <functional>
#include <thread>
#include <type_traits>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

constexpr unsigned kThreads = 4;
constexpr unsigned kRounds = 25;

/// Runs work(round) `kRounds` times in each of the threads, which start together.
void inThreads(const std::function<void(unsigned)>& work) {
    std::atomic<unsigned> waiting{kThreads};
    std::vector<std::thread> threads;
    for (unsigned t = 0; t < kThreads; ++t)
        threads.emplace_back([&, t] {
            --waiting;
            while (waiting > 0) std::this_thread::yield();
            for (unsigned i = 0; i < kRounds; ++i) work(t + i);
        });
    for (auto& thread : threads) thread.join();
}

mrpt::obs::CObservation3DRangeScan::Ptr makeImage() {
    auto scan = mrpt::obs::CObservation3DRangeScan::Create();
    scan->sensorLabel = "DEPTH";
    scan->sensorPose = test::someSensorPose();
    scan->cameraParams.ncols = 80;
    scan->cameraParams.nrows = 60;
    scan->cameraParams.setIntrinsicParamsFromValues(70, 70, 40, 30);
    scan->hasRangeImage = true;
    scan->range_is_depth = true;
    scan->rangeUnits = 0.001f;
    scan->maxRange = 6;
    scan->rangeImage_setSize(60, 80);
    for (int row = 0; row < 60; ++row)
        for (int column = 0; column < 80; ++column)
            scan->rangeImage(row, column) =
                static_cast<std::uint16_t>(2000 + 10 * column + 5 * row);
    return scan;
}

/// Observations whose data are in files, and the same ones in memory.
class StoredScans {
 public:
    StoredScans() {
        image_->rangeImage_convertToExternalStorage(folder_.file("image.bin"), "");
        image_->unload();
        {
            mrpt::io::CFileGZOutputStream file(folder_.file("cloud.bin"));
            mrpt::serialization::archiveFrom(file) << *cloud_->pointcloud;
        }
        cloud_->setAsExternalStorage(
            folder_.file("cloud.bin"),
            mrpt::obs::CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
        cloud_->pointcloud.reset();
    }

    std::vector<const mrpt::obs::CObservation*> inFiles() const {
        return {image_.get(), cloud_.get()};
    }
    std::vector<const mrpt::obs::CObservation*> inMemory() const {
        return {imageInMemory_.get(), cloudInMemory_.get()};
    }
    bool nothingIsLoaded() const {
        return image_->rangeImage.size() == 0 && !cloud_->pointcloud;
    }
    const mrpt::obs::CObservation3DRangeScan& image() const { return *image_; }

 private:
    const test::TempFolder folder_;
    const mrpt::obs::CObservation3DRangeScan::Ptr image_ = makeImage(),
                                                  imageInMemory_ = makeImage();
    const mrpt::obs::CObservationPointCloud::Ptr cloud_ = test::randomCloud(500, 1),
                                                 cloudInMemory_ = test::randomCloud(500, 1);
};

/// Poses of particles.
std::vector<CPose3D> posesAround(const CPose3D& pose) {
    std::vector<CPose3D> poses;
    for (int i = 0; i < 7; ++i)
        poses.push_back(pose + CPose3D(0.05 * i, -0.03 * i, 0.01 * i, 0.02 * i, 0, 0));
    return poses;
}

TEST(ConcurrentReads, OfStoredScansGiveWhatOneThreadGets) {
    const StoredScans scans;
    std::vector<std::optional<SensorReturns>> expected;
    for (const auto* scan : scans.inMemory()) expected.push_back(readReturns(*scan, {}));
    std::atomic<unsigned> wrong{0};
    inThreads([&](unsigned round) {
        const std::size_t which = round % 2;
        const auto& scan = *scans.inFiles()[which];
        const auto returns = readReturns(scan, {});
        wrong += !canReadReturns(scan) || !returns || returns->hits != expected[which]->hits;
    });
    EXPECT_EQ(wrong, 0u);
    EXPECT_TRUE(scans.nothingIsLoaded());
}

TEST(ConcurrentReads, WhatTheUserLoadedStays) {
    const StoredScans scans;
    scans.image().load();
    std::atomic<unsigned> wrong{0};
    inThreads([&](unsigned) { wrong += !readReturns(scans.image(), {}); });
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(scans.image().rangeImage.size(), 0);
}

TEST(ConcurrentReads, AMissingFileIsAnErrorInEveryThread) {
    const auto cloud = test::randomCloud(1, 1);
    cloud->setAsExternalStorage(
        "/no/such/cloud.bin",
        mrpt::obs::CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
    cloud->pointcloud.reset();
    std::atomic<unsigned> errors{0};
    inThreads([&](unsigned) {
        try {
            readReturns(*cloud, {});
        } catch (const std::exception&) {
            ++errors;
        }
    });
    EXPECT_EQ(errors, kThreads * kRounds);
}

template <class Map>
class ConcurrentMapReads : public testing::Test {};
using Maps = testing::Types<CSuperRayGridMap2D, CSuperRayGridMap3D, CSuperRayOctoMap,
                            CSuperRayPointsMap3D>;
TYPED_TEST_SUITE(ConcurrentMapReads, Maps);

TYPED_TEST(ConcurrentMapReads, Likelihood) {
    const StoredScans scans;
    const auto poses = posesAround(test::someRobotPose());
    TypeParam filled(0.1);
    for (const auto* scan : scans.inMemory())
        ASSERT_TRUE(filled.insertObservation(*scan, poses[0]));
    // Another map computes what is expected: caches of this one are to be made in threads.
    const TypeParam map = filled;
    std::vector<std::vector<double>> expected;
    for (const auto* scan : scans.inMemory()) {
        expected.emplace_back();
        for (const auto& pose : poses)
            expected.back().push_back(filled.computeObservationLikelihood(*scan, pose));
    }
    ASSERT_NE(expected[0][0], expected[0][6]);
    std::atomic<unsigned> wrong{0};
    inThreads([&](unsigned round) {
        const std::size_t scan = round % 2, pose = round % poses.size();
        const auto& observation = *scans.inFiles()[scan];
        wrong +=
            !map.canComputeObservationLikelihood(observation) ||
            map.computeObservationLikelihood(observation, poses[pose]) != expected[scan][pose];
    });
    EXPECT_EQ(wrong, 0u);
    EXPECT_TRUE(scans.nothingIsLoaded());
}

TYPED_TEST(ConcurrentMapReads, Matching) {
    // MRPT's own points maps throw, too, in one thread: "no points in the KD-tree".
    if (std::is_base_of_v<mrpt::maps::CPointsMap, TypeParam>)
        GTEST_SKIP() << "MRPT's points maps, asked for 2D and then for 3D matches, throw (MRPT "
                        "2.14): NOT TESTED with ours, which leaves matching to MRPT";
    const StoredScans scans;
    const CPose3D pose = test::someRobotPose();
    TypeParam filled(0.1), filledOther(0.1);
    for (const auto* scan : scans.inMemory()) {
        ASSERT_TRUE(filled.insertObservation(*scan, pose));
        ASSERT_TRUE(filledOther.insertObservation(*scan, pose + CPose3D(0.1, 0, 0, 0, 0, 0)));
    }
    const TypeParam map = filled, other = filledOther;
    mrpt::maps::TMatchingParams params;
    params.maxDistForCorrespondence = 0.3f;
    mrpt::maps::TMatchingRatioParams ratioParams;
    ratioParams.maxDistForCorr = 0.2f;
    const auto pairs = [&](const TypeParam& a, const TypeParam& b, bool flat) {
        mrpt::tfest::TMatchingPairList found;
        mrpt::maps::TMatchingExtraResults results;
        if (flat)
            a.determineMatching2D(&b, {}, found, params, results);
        else
            a.determineMatching3D(&b, {}, found, params, results);
        return found.size();
    };
    const std::size_t in2D = pairs(filled, filledOther, true),
                      in3D = pairs(filled, filledOther, false);
    const float ratio = filled.compute3DMatchingRatio(&filledOther, {}, ratioParams);
    ASSERT_GT(in2D, 0u);
    ASSERT_GT(in3D, 0u);
    ASSERT_GT(ratio, 0.0f);
    std::atomic<unsigned> wrong{0};
    inThreads([&](unsigned round) {
        switch (round % 4) {
            case 0:
                wrong += pairs(map, other, true) != in2D;
                break;
            case 1:
                wrong += pairs(map, other, false) != in3D;
                break;
            case 2:
                wrong += map.compute3DMatchingRatio(&other, {}, ratioParams) != ratio;
                break;
            default: {
                mrpt::opengl::CSetOfObjects objects;
                map.getVisualizationInto(objects);
                wrong += objects.empty();
            }
        }
    });
    EXPECT_EQ(wrong, 0u);
}

TYPED_TEST(ConcurrentMapReads, Views) {
    const StoredScans scans;
    TypeParam filled(0.1);
    for (const auto* scan : scans.inMemory())
        ASSERT_TRUE(filled.insertObservation(*scan, test::someRobotPose()));
    const TypeParam map = filled;  // nothing of it is drawn yet
    const auto voxels = [](const TypeParam& m) {
        mrpt_viz::CSetOfObjects objects;
        m.getVisualizationInto(objects);
        return objects.template getByClass<mrpt_viz::COctoMapVoxels>()->getVoxelCount(
            mrpt_viz::VOXEL_SET_OCCUPIED);
    };
    const std::size_t expected = voxels(filled);
    ASSERT_GT(expected, 0u);
    std::atomic<unsigned> wrong{0};
    inThreads([&](unsigned) { wrong += voxels(map) != expected || map.asString().empty(); });
    EXPECT_EQ(wrong, 0u);
}

// Copies share cells; different maps may be written to at the same time.
TYPED_TEST(ConcurrentMapReads, InsertionIntoCopies) {
    const StoredScans scans;
    const CPose3D pose = test::someRobotPose();
    TypeParam map(0.2), expected(0.2);
    for (TypeParam* m : {&map, &expected})
        ASSERT_TRUE(m->insertObservation(*scans.inMemory()[0], pose));
    expected.insertObservation(*scans.inMemory()[1], pose);
    std::atomic<unsigned> wrong{0};
    const auto view = [](const TypeParam& m) {
        mrpt::io::CMemoryStream stream;
        mrpt::serialization::archiveFrom(stream) << m;
        return stream.getTotalBytesCount();
    };
    const auto size = view(expected);
    inThreads([&](unsigned) {
        TypeParam copy(map);
        copy.insertObservation(*scans.inFiles()[1], pose);
        wrong += view(copy) != size;
    });
    EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace superray
