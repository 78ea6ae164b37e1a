// SPDX-License-Identifier: BSD-3-Clause
// Copies share their cells, and nobody can tell but by the clock.

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/serialization/CArchive.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayQuadMap.h>

#include <thread>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::serialization::archiveFrom;

template <class Map>
class SharedStorageOf : public ::testing::Test {
 protected:
    Map original{0.1};
    void SetUp() override {
        for (unsigned i = 0; i < 3; ++i)
            ASSERT_TRUE(original.insertObservation(*test::randomCloud(500, i)));
    }
    static void change(Map& m) {
        ASSERT_TRUE(m.insertObservation(*test::randomCloud(200, 77), test::someRobotPose()));
    }
};
using Maps = ::testing::Types<CSuperRayGridMap3D, CSuperRayOctoMap, CSuperRayGridMap2D,
                              CSuperRayQuadMap>;
TYPED_TEST_SUITE(SharedStorageOf, Maps);

TYPED_TEST(SharedStorageOf, CopiesShareUntilOneIsWritten) {
    auto& map = this->original;
    const auto digest = map.digest();
    TypeParam copy(map), assigned;
    assigned = map;
    EXPECT_EQ(&copy.storage(), &map.storage());
    EXPECT_EQ(&assigned.storage(), &map.storage());

    this->change(copy);
    EXPECT_NE(&copy.storage(), &map.storage());
    EXPECT_NE(copy.digest(), digest);
    EXPECT_EQ(map.digest(), digest);
    EXPECT_EQ(assigned.digest(), digest);
    const auto changed = copy.digest();

    this->change(map);
    EXPECT_EQ(map.digest(), changed) << "the same scan on the same cells";
    EXPECT_EQ(assigned.digest(), digest);
    // The last one left alone need not copy.
    const auto* cells = &assigned.storage();
    this->change(assigned);
    EXPECT_EQ(&assigned.storage(), cells);
    EXPECT_EQ(assigned.digest(), changed);
}

TYPED_TEST(SharedStorageOf, ClearingOneCopyLeavesTheOther) {
    auto& map = this->original;
    const auto digest = map.digest();
    TypeParam copy(map);
    copy.clear();
    EXPECT_TRUE(copy.isEmpty());
    EXPECT_EQ(map.digest(), digest);
    copy = map;
    map.clear();
    EXPECT_TRUE(map.isEmpty());
    EXPECT_EQ(copy.digest(), digest);
    copy.clear();
    this->change(copy);
    EXPECT_TRUE(map.isEmpty());
}

TYPED_TEST(SharedStorageOf, MultiMetricMapsCopyByStreamAndShareToo) {
    mrpt::maps::CMultiMetricMap maps;
    maps.maps.push_back(std::make_shared<TypeParam>(this->original));
    const mrpt::maps::CMultiMetricMap copy(maps);
    auto& first = dynamic_cast<TypeParam&>(*maps.maps[0]);
    const auto& copied = dynamic_cast<const TypeParam&>(*copy.maps[0]);
    ASSERT_NE(&first, &copied);
    EXPECT_EQ(&copied.storage(), &first.storage());
    const auto digest = copied.digest();
    this->change(first);
    EXPECT_EQ(copied.digest(), digest);
    // What was read once is not taken for what is there now.
    const mrpt::maps::CMultiMetricMap later(maps);
    EXPECT_EQ(dynamic_cast<const TypeParam&>(*later.maps[0]).digest(), first.digest());
    EXPECT_NE(first.digest(), digest);
}

TYPED_TEST(SharedStorageOf, StreamsOutliveTheMap) {
    mrpt::io::CMemoryStream stream;
    const auto digest = this->original.digest();
    {
        TypeParam gone(this->original);
        this->change(gone);  // its own cells
        archiveFrom(stream) << gone;
    }
    stream.Seek(0);
    TypeParam read;
    archiveFrom(stream) >> read;
    EXPECT_NE(read.digest(), digest);
    this->change(this->original);
    EXPECT_EQ(read.digest(), this->original.digest());
}

TYPED_TEST(SharedStorageOf, BytesAreThoseOfTheCellsNow) {
    auto& map = this->original;
    const auto readBack = [&] {
        mrpt::io::CMemoryStream stream;
        archiveFrom(stream) << map;
        stream.Seek(0);
        TypeParam read;
        archiveFrom(stream) >> read;
        return read.digest();
    };
    // Alone with its cells, the map keeps their bytes until it is changed.
    EXPECT_EQ(readBack(), map.digest());
    const auto* cells = &map.storage();
    this->change(map);
    EXPECT_EQ(&map.storage(), cells);
    EXPECT_EQ(readBack(), map.digest());
    map.clear();
    EXPECT_EQ(readBack(), map.digest());
}

// Run under the thread sanitizer, this finds what is shared and written.
TYPED_TEST(SharedStorageOf, CopiesInManyThreads) {
    const auto digest = this->original.digest();
    const auto scan = test::randomCloud(200, 77);
    TypeParam expected(this->original);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(expected.insertObservation(*scan));
    std::vector<TypeParam> copies(4, this->original);
    std::vector<std::string> digests(copies.size());
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < copies.size(); ++t)
        threads.emplace_back([&, t] {
            for (int i = 0; i < 3; ++i) {
                copies[t].insertObservation(*scan);
                mrpt::io::CMemoryStream stream;
                archiveFrom(stream) << copies[t];
                stream.Seek(0);
                TypeParam read;
                archiveFrom(stream) >> read;  // perhaps another thread's cells
                copies[t] = read;
            }
            digests[t] = copies[t].digest();
        });
    for (auto& thread : threads) thread.join();
    for (const auto& d : digests) EXPECT_EQ(d, expected.digest());
    EXPECT_EQ(this->original.digest(), digest);
}

}  // namespace
}  // namespace superray
