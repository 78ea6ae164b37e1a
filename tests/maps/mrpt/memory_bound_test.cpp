// SPDX-License-Identifier: BSD-3-Clause
// The memory bound: it is kept, and what would pass it changes nothing.

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayPointsMap.h>
#include <superray/maps/CSuperRayQuadMap.h>
#include <superray/storage/memory_limit_error.h>

#include "maps/occupancy_of.h"
#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

constexpr std::size_t kMebi = std::size_t{1} << 20;

template <class Map>
constexpr int cellDimension =
    std::is_base_of_v<CSuperRayMapBase<2>, Map> || std::is_base_of_v<CSuperRayPointsMap<2>, Map>
        ? 2
        : 3;

template <class Map>
class MemoryBound : public ::testing::Test {
 protected:
    static constexpr bool kIsPoints = std::is_base_of_v<mrpt::maps::CPointsMap, Map>;

    static std::unique_ptr<Map> bounded(std::uint32_t megabytes, Method method,
                                        unsigned threads, double windowRadius = 0) {
        auto map = std::make_unique<Map>(0.1);
        TMapOptions options = test::occupancyOf(*map).options();
        options.creation.max_memory_megabytes = megabytes;
        options.insertion.method = method;
        options.insertion.threads = threads;
        options.insertion.windowRadius = windowRadius;
        // Neither in files nor beside points.
        options.insertion.pointStatistics = !kIsPoints && megabytes != 0;
        map->setOptions(options);
        return map;
    }
    /// A scan from a place of its own.
    static CPose3D poseOf(int scan) { return {3.0 * scan, 0.4 * scan, 0, 0.1 * scan, 0, 0}; }
    static mrpt::obs::CObservation::Ptr scanOf(int scan) {
        return test::randomCloud(600, static_cast<unsigned>(scan));
    }
};
using Maps = ::testing::Types<CSuperRayGridMap2D, CSuperRayQuadMap, CSuperRayGridMap3D,
                              CSuperRayOctoMap, CSuperRayPointsMap2D, CSuperRayPointsMap3D>;
TYPED_TEST_SUITE(MemoryBound, Maps);

/// All of a map that a user can see.
template <class Map>
struct State {
    explicit State(const Map& map)
        : digest(test::occupancyOf(map).digest()),
          options(test::occupancyOf(map).optionsAsIniText()),
          stamp(test::occupancyOf(map).changeStamp()),
          scans(test::occupancyOf(map).totals().scans),
          held(map.heldBytes()) {
        if constexpr (std::is_base_of_v<mrpt::maps::CPointsMap, Map>) {
            for (std::size_t i = 0; i < map.size(); ++i) {
                Eigen::Vector3f p;
                map.getPoint(i, p.x(), p.y(), p.z());
                points.insert(points.end(), {p.x(), p.y(), p.z()});
            }
        }
    }
    bool operator==(const State& o) const {
        return digest == o.digest && options == o.options && stamp == o.stamp &&
               scans == o.scans && held == o.held && points == o.points;
    }
    std::string digest, options;
    std::uint64_t stamp, scans;
    std::size_t held;
    std::vector<float> points;
};

TYPED_TEST(MemoryBound, IsKeptAndTheScanThatWouldPassItChangesNothing) {
    constexpr std::uint32_t kMegabytes = cellDimension<TypeParam> == 2 ? 1 : 6;
    constexpr std::size_t kBound = kMegabytes * kMebi;
    for (const Method method : {Method::automatic, Method::reference})
        for (const unsigned threads : {1u, 2u}) {
            const auto map = this->bounded(kMegabytes, method, threads);
            const auto twin = this->bounded(0, method, threads);  // without a bound
            int scan = 0;
            for (;; ++scan) {
                ASSERT_LT(scan, 3000) << "the bound is never met";
                const State before(*map);
                try {
                    map->insertObservation(*this->scanOf(scan), this->poseOf(scan));
                } catch (const MemoryLimitError& e) {
                    EXPECT_TRUE(State(*map) == before);
                    EXPECT_EQ(e.limit(), kBound);
                    EXPECT_EQ(e.held(), before.held);
                    EXPECT_GT(e.needed(), kBound);
                    for (const char* part :
                         {"max_memory_megabytes = ", "this scan", "the map holds",
                          "coarser resolution", "windowRadius", "raise the bound"})
                        EXPECT_CONTAINS(std::string(e.what()), part);
                    break;
                }
                ASSERT_LE(map->heldBytes(), kBound);
                twin->insertObservation(*this->scanOf(scan), this->poseOf(scan));
            }
            EXPECT_GT(scan, 1);
            EXPECT_GT(map->heldBytes(), kBound / 4) << "far too early";
            EXPECT_EQ(test::occupancyOf(*map).digest(), test::occupancyOf(*twin).digest());
            // The same scan fits a map with a higher bound.
            TMapOptions options = test::occupancyOf(*map).options();
            options.creation.max_memory_megabytes = 64;
            map->setOptions(options);
            EXPECT_TRUE(map->insertObservation(*this->scanOf(scan), this->poseOf(scan)));
            twin->insertObservation(*this->scanOf(scan), this->poseOf(scan));
            EXPECT_EQ(test::occupancyOf(*map).digest(), test::occupancyOf(*twin).digest());
        }
}

TYPED_TEST(MemoryBound, WithAWindowAMapLivesForEver) {
    // The error with the window off shows that the bound is met.
    const auto map = this->bounded(4, Method::automatic, 2, 3);
    const auto twin = this->bounded(0, Method::automatic, 1, 3);
    for (int scan = 0; scan < 120; ++scan) {
        const auto observation = test::randomCloud(200, static_cast<unsigned>(scan), 0.5, 2);
        map->insertObservation(*observation, this->poseOf(scan));
        twin->insertObservation(*observation, this->poseOf(scan));
        ASSERT_LE(map->heldBytes(), 4 * kMebi) << scan;
    }
    EXPECT_EQ(test::occupancyOf(*map).digest(), test::occupancyOf(*twin).digest());
    EXPECT_GT(test::occupancyOf(*map).totals().forgottenBlocks, 50u);
}

TYPED_TEST(MemoryBound, LargerFilesAndStreamsAreRefused) {
    const auto large = this->bounded(0, Method::automatic, 1);
    for (int scan = 0; large->heldBytes() < 3 * kMebi; ++scan)
        large->insertObservation(*this->scanOf(scan), this->poseOf(scan));
    const test::TempFolder folder;
    const std::string path = folder.file("large.srmap");
    test::occupancyOf(*large).saveToFile(path);

    const auto map = this->bounded(1, Method::automatic, 1);
    map->insertObservation(*test::randomCloud(50, 5), {});
    const State before(*map);
    EXPECT_THROW(map->loadFromFile(path), MemoryLimitError);
    EXPECT_TRUE(State(*map) == before);

    mrpt::io::CMemoryStream stream;
    auto archive = mrpt::serialization::archiveFrom(stream);
    archive << *large;
    stream.Seek(0);
    const std::string refused = test::messageOf([&] { archive >> *map; });
    EXPECT_CONTAINS(refused, "max_memory_megabytes");
    EXPECT_TRUE(State(*map) == before);

    TMapOptions options = test::occupancyOf(*map).options();
    options.creation.load_from = path;
    EXPECT_THROW(map->setOptions(options), MemoryLimitError);
    EXPECT_TRUE(State(*map) == before);
    // The bound of the options counts, not that of before.
    options.creation.max_memory_megabytes = 64;
    map->setOptions(options);
    EXPECT_EQ(test::occupancyOf(*map).digest(), test::occupancyOf(*large).digest());
    EXPECT_EQ(test::occupancyOf(*map).options().creation.max_memory_megabytes, 64u);
    options.creation.load_from.clear();
    options.creation.max_memory_megabytes = 1;
    EXPECT_THROW(map->setOptions(options), MemoryLimitError) << "it holds more";
    EXPECT_EQ(test::occupancyOf(*map).options().creation.max_memory_megabytes, 64u);
}

TYPED_TEST(MemoryBound, TheTighterBoundIsKeptWhenAMapIsLoaded) {
    const test::TempFolder folder;
    const std::string path = folder.file("small.srmap");
    const auto saved = this->bounded(20, Method::automatic, 1);
    saved->insertObservation(*test::randomCloud(50, 5), {});
    test::occupancyOf(*saved).saveToFile(path);
    for (const auto& [own, kept] : {std::pair{0u, 20u}, {10u, 10u}, {30u, 20u}}) {
        const auto map = this->bounded(own, Method::automatic, 1);
        map->loadFromFile(path);
        EXPECT_EQ(test::occupancyOf(*map).options().creation.max_memory_megabytes, kept);
        EXPECT_EQ(test::occupancyOf(*map).digest(), test::occupancyOf(*saved).digest());
    }
}

TYPED_TEST(MemoryBound, FilesOfABoundedMapCanBeLoadedWithinIt) {
    const auto map = this->bounded(4, Method::automatic, 1);
    try {
        for (int scan = 0;; ++scan)
            map->insertObservation(*this->scanOf(scan), this->poseOf(scan));
    } catch (const MemoryLimitError&) {
    }
    if constexpr (!TestFixture::kIsPoints) {
        const test::TempFolder folder;
        map->saveToFile(folder.file("full.srmap"));
        TypeParam loaded(0.1);
        loaded.loadFromFile(folder.file("full.srmap"));
        EXPECT_EQ(loaded.digest(), map->digest());
    }
    const TypeParam copy(*map);
    EXPECT_EQ(test::occupancyOf(copy).options().creation.max_memory_megabytes, 4u);
}

TEST(MemoryBoundOfMaps, MergesAreRefused) {
    CSuperRayGridMap3D map(0.1), other(0.1);
    TMapOptions options = map.options();
    options.creation.max_memory_megabytes = 1;
    map.setOptions(options);
    map.insertObservation(*test::randomCloud(20, 1), {});
    for (unsigned i = 0; i < 8; ++i)
        other.insertObservation(*test::randomCloud(1000, i), CPose3D(6.0 * i, 0, 0, 0, 0, 0));
    const State before(map);
    EXPECT_THROW(map.merge(other, CPose3D()), MemoryLimitError);
    EXPECT_TRUE(State(map) == before);
    map.merge(map, CPose3D());
    EXPECT_NE(map.digest(), before.digest);
}

TEST(MemoryBoundOfMaps, ReservesKeepToIt) {
    for (const auto& className : mapClassNames()) {
        const auto map = createMap(className);
        auto& super = test::interfaceOf(*map);
        TMapOptions options = super.options();
        options.creation.max_memory_megabytes = 8;
        options.creation.reserve_megabytes = 9;
        EXPECT_CONTAINS(test::messageOf([&] { super.setOptions(options); }),
                        "reserve_megabytes <= max_memory_megabytes");
        options.creation.reserve_megabytes = 8;
        super.setOptions(options);
        EXPECT_LE(super.heldBytes(), 8 * kMebi) << className;
        EXPECT_GT(super.heldBytes(), 3 * kMebi) << className;
        EXPECT_TRUE(map->insertObservation(*test::randomCloud(100, 1))) << className;
        options.creation.reserve_megabytes = 7;
        super.setOptions(options);
        EXPECT_LE(super.heldBytes(), 8 * kMebi) << className;
    }
}

}  // namespace
}  // namespace superray
