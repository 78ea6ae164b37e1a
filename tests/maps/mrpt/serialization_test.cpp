// SPDX-License-Identifier: BSD-3-Clause
// Streams, copies and files keep every bit and change nothing.

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/serialization/CArchive.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayQuadMap.h>

#include <fstream>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::serialization::archiveFrom;

/// A map with contents and none of the default options.
mrpt::maps::CMetricMap::Ptr makeFilled(const std::string& className) {
    const auto map = createMap(className);
    test::interfaceOf(*map).setResolution(1.0 / 7);
    for (unsigned i = 0; i < 3; ++i)
        EXPECT_TRUE(map->insertObservation(*test::randomCloud(1000, i), test::someRobotPose()));
    test::interfaceOf(*map).setOptions(test::unusualOptions());
    return map;
}

std::vector<std::uint8_t> bytesOf(const mrpt::maps::CMetricMap& map) {
    std::vector<std::uint8_t> bytes;
    mrpt::serialization::ObjectToOctetVector(&map, bytes);
    return bytes;
}

TEST(Serialization, RoundTripKeepsContentsAndOptions) {
    for (const auto& className : mapClassNames()) {
        const auto map = makeFilled(className);
        const auto& source = test::interfaceOf(*map);
        const auto digest = source.digest();
        const auto options = source.optionsAsIniText();
        const auto cells = source.cellTotals();
        ASSERT_GT(cells.occupied, 100u);
        ASSERT_EQ(options, test::unusualOptions().toText());

        mrpt::io::CMemoryStream stream;
        archiveFrom(stream) << *map;
        EXPECT_EQ(source.digest(), digest) << "the source may not change";
        EXPECT_EQ(source.optionsAsIniText(), options);
        stream.Seek(0);
        const auto object = archiveFrom(stream).ReadObject();
        const auto read = std::dynamic_pointer_cast<mrpt::maps::CMetricMap>(object);
        ASSERT_TRUE(read);
        EXPECT_EQ(read->GetRuntimeClass(), map->GetRuntimeClass());
        EXPECT_EQ(test::interfaceOf(*read).digest(), digest);
        EXPECT_EQ(test::interfaceOf(*read).optionsAsIniText(), options);
        EXPECT_EQ(bytesOf(*read), bytesOf(*map));
        EXPECT_FALSE(read->genericMapParams.enableObservationLikelihood);
    }
}

TEST(Serialization, EmptyMapsStayEmpty) {
    for (const auto& className : mapClassNames()) {
        mrpt::io::CMemoryStream stream;
        archiveFrom(stream) << *createMap(className);
        stream.Seek(0);
        const auto read =
            std::dynamic_pointer_cast<mrpt::maps::CMetricMap>(archiveFrom(stream).ReadObject());
        ASSERT_TRUE(read);
        EXPECT_TRUE(read->isEmpty());
    }
}

TEST(Serialization, DamagedStreamsThrowAndLeaveTheMap) {
    const auto bytes = bytesOf(*makeFilled("CSuperRayOctoMap"));
    ASSERT_GT(bytes.size(), 1000u);
    CSuperRayOctoMap target(0.2);
    ASSERT_TRUE(target.insertObservation(*test::randomCloud(100, 9)));
    const auto digest = target.digest();
    const auto options = target.optionsAsIniText();
    std::size_t tried = 0, refused = 0;
    const auto tryRead = [&](const std::vector<std::uint8_t>& data) {
        ++tried;
        mrpt::io::CMemoryStream stream(data.data(), data.size());
        try {
            archiveFrom(stream) >> target;
            target = CSuperRayOctoMap(0.2);
            target.insertObservation(*test::randomCloud(100, 9));
        } catch (const std::exception&) {
            ++refused;
        }
        EXPECT_EQ(target.digest(), digest);
        EXPECT_EQ(target.optionsAsIniText(), options);
    };
    std::mt19937 generator(3);
    for (int i = 0; i < 200; ++i) {
        auto damaged = bytes;
        damaged[generator() % bytes.size()] ^= static_cast<std::uint8_t>(1 + generator() % 255);
        tryRead(damaged);
    }
    for (int i = 0; i < 50; ++i) {
        auto cut = bytes;
        cut.resize(generator() % bytes.size());
        tryRead(cut);
    }
    EXPECT_EQ(tried, 250u);
    // All but damage to what MRPT itself writes around the map and ignores.
    EXPECT_GE(refused, 248u);
}

TEST(Serialization, AChangedDigitOfAnOptionIsNoticed) {
    auto bytes = bytesOf(*makeFilled("CSuperRayGridMap3D"));
    const std::string marker = "probHit = 0.65";
    const auto text = std::search(bytes.begin(), bytes.end(), marker.begin(), marker.end());
    ASSERT_NE(text, bytes.end());
    *(text + static_cast<std::ptrdiff_t>(marker.size()) - 1) = '6';
    mrpt::io::CMemoryStream stream(bytes.data(), bytes.size());
    CSuperRayGridMap3D target;
    EXPECT_CONTAINS(test::messageOf([&] { archiveFrom(stream) >> target; }), "checksum");
    EXPECT_TRUE(target.isEmpty());
}

TEST(Serialization, AWrongSizeIsNotAllocated) {
    // Class name and version as MRPT writes them, then a size of 2^60.
    auto bytes = bytesOf(CSuperRayGridMap2D());
    const std::string marker = "[creationOpts]";
    const auto text = std::search(bytes.begin(), bytes.end(), marker.begin(), marker.end());
    ASSERT_NE(text, bytes.end());
    ASSERT_GE(text - bytes.begin(), 8);
    *(text - 1) = 0x10;  // highest byte of the size before the text
    mrpt::io::CMemoryStream stream(bytes.data(), bytes.size());
    CSuperRayGridMap2D target;
    const auto message = test::messageOf([&] { archiveFrom(stream) >> target; });
    EXPECT_CONTAINS(message, "CSuperRayGridMap2D");
}

TEST(Copies, AreDeepAndComplete) {
    CSuperRayGridMap3D original(0.2);
    ASSERT_TRUE(original.insertObservation(*test::randomCloud(300, 1)));
    original.insertionOptions.maxrange = 7;
    CSuperRayGridMap3D copy(original), assigned(0.5);
    assigned = original;
    const std::unique_ptr<mrpt::rtti::CObject> cloned(original.clone());
    auto& clone = dynamic_cast<CSuperRayGridMap3D&>(*cloned);
    const auto before = original.digest();
    for (auto* map : {&copy, &assigned, &clone}) {
        EXPECT_EQ(map->digest(), before);
        EXPECT_EQ(map->optionsAsIniText(), original.optionsAsIniText());
        EXPECT_EQ(map->totals().rays, 300u);
        ASSERT_TRUE(map->insertObservation(*test::randomCloud(300, 2)));
        EXPECT_NE(map->digest(), before);
    }
    EXPECT_EQ(original.digest(), before);
    EXPECT_EQ(copy.digest(), clone.digest());
    original.clear();
    EXPECT_FALSE(copy.isEmpty());
}

TEST(Copies, OfAMultiMetricMapHaveTheSameContents) {
    mrpt::maps::CMultiMetricMap all;
    for (const auto& className : mapClassNames()) all.maps.push_back(makeFilled(className));
    const mrpt::maps::CMultiMetricMap copy(all);
    ASSERT_EQ(copy.maps.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) {
        const auto& a = test::interfaceOf(*all.maps.at(i));
        const auto& b = test::interfaceOf(*copy.maps.at(i));
        EXPECT_NE(&a, &b);
        EXPECT_EQ(a.digest(), b.digest());
        EXPECT_EQ(a.optionsAsIniText(), b.optionsAsIniText());
    }
}

TEST(Files, RoundTripKeepsContentsAndOptions) {
    const test::TempFolder folder;
    for (const auto& className : mapClassNames()) {
        const auto map = makeFilled(className);
        const auto& source = test::interfaceOf(*map);
        const auto path = folder.file(className + ".srmap");
        source.saveToFile(path);
        const auto read = loadMap(path);
        EXPECT_EQ(read->GetRuntimeClass(), map->GetRuntimeClass());
        EXPECT_EQ(test::interfaceOf(*read).digest(), source.digest());
        EXPECT_EQ(test::interfaceOf(*read).optionsAsIniText(), source.optionsAsIniText());
        EXPECT_EQ(test::interfaceOf(*read).totals().scans, 0u);
    }
}

// Options are public members, so anything may be in them.
TEST(Files, AMapThatCouldNotBeLoadedIsNotSaved) {
    CSuperRayGridMap3D map(0.1);
    ASSERT_TRUE(map.insertObservation(*test::randomCloud(100, 1)));
    const test::TempFolder folder;
    const std::string path = folder.file("kept.srmap");
    map.saveToFile(path);
    const std::string digest = map.digest();

    map.insertionOptions.minrange = 5;
    map.insertionOptions.maxrange = 4;
    const auto message = test::messageOf([&] { map.saveToFile(path); });
    EXPECT_CONTAINS(message, path);
    EXPECT_CONTAINS(message, "minrange = 5");
    EXPECT_THROW(bytesOf(map), std::exception);
    CSuperRayGridMap3D loaded(0.1);
    loaded.loadFromFile(path);
    EXPECT_EQ(loaded.digest(), digest);

    map.insertionOptions = {};
    map.likelihoodOptions.sigma = 0;
    EXPECT_THROW(map.saveToFile(path), MapFileError);
    map.likelihoodOptions = {};
    map.saveToFile(path);
}

TEST(Files, OtherStorageYesOtherDimensionNo) {
    const test::TempFolder folder;
    const auto path = folder.file("map.srmap");
    const auto grid = makeFilled("CSuperRayGridMap3D");
    test::interfaceOf(*grid).saveToFile(path);
    CSuperRayOctoMap octree(0.3);
    ASSERT_TRUE(octree.insertObservation(*test::randomCloud(100, 1)));
    octree.loadFromFile(path);
    EXPECT_EQ(octree.digest(), test::interfaceOf(*grid).digest());
    EXPECT_EQ(octree.resolution(), 1.0 / 7);

    CSuperRayQuadMap quad(0.3);
    ASSERT_TRUE(quad.insertObservation(*test::randomCloud(100, 1)));
    const auto before = quad.digest();
    const auto message = test::messageOf([&] { quad.loadFromFile(path); });
    EXPECT_CONTAINS(message, "map.srmap");
    EXPECT_CONTAINS(message, "CSuperRayGridMap3D");
    EXPECT_CONTAINS(message, "CSuperRayQuadMap");
    EXPECT_EQ(quad.digest(), before);
}

TEST(Files, UnreadableOnesAreErrorsAndLeaveTheMap) {
    const test::TempFolder folder;
    CSuperRayGridMap3D map(0.3);
    ASSERT_TRUE(map.insertObservation(*test::randomCloud(100, 1)));
    const auto before = map.digest();
    const auto expectRefused = [&](const std::string& path) {
        EXPECT_THROW(map.loadFromFile(path), MapFileError);
        EXPECT_THROW(loadMap(path), MapFileError);
        EXPECT_EQ(map.digest(), before);
    };
    expectRefused(folder.file("missing.srmap"));
    std::ofstream(folder.file("empty.srmap")).close();
    expectRefused(folder.file("empty.srmap"));

    const auto cells = encodeCells(map.storage());
    MapFileHeader header{"CSuperRayGridMap3D", 3, 0.3, map.optionsAsIniText()};
    header.options += "[insertOpts]\nfuture = 1\n";
    saveMapFile(folder.file("options.srmap"), header, cells);
    expectRefused(folder.file("options.srmap"));
    header.options = map.optionsAsIniText();
    header.className = "CSomethingElse";
    saveMapFile(folder.file("class.srmap"), header, cells);
    EXPECT_CONTAINS(test::messageOf([&] { loadMap(folder.file("class.srmap")); }),
                    "CSomethingElse");
    EXPECT_THROW(map.saveToFile(folder.file("no/such/folder.srmap")), MapFileError);
}

}  // namespace
}  // namespace superray
