// SPDX-License-Identifier: BSD-3-Clause
// Files: bit-exact round trips, and an error for everything that is not right.

#include "storage/file/map_file_tools.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <fstream>

namespace superray::test {
namespace {

template <typename Case>
class CellsOfStorage : public ::testing::Test {};
TYPED_TEST_SUITE(CellsOfStorage, AllStorages);

TYPED_TEST(CellsOfStorage, RoundTripIntoEveryStorageIsBitExact) {
    constexpr int Dim = TypeParam::Dim;
    const CellGeometry<Dim> geometry(0.05);
    typename TypeParam::Map map(geometry);
    const Cells<Dim> cells = fillRandomly<Dim>(map, 42);
    ASSERT_GT(cells.size(), 200u);
    const std::string digest = contentDigest<Dim>(map);
    const auto bytes = encodeCells<Dim>(map);
    EXPECT_EQ(contentDigest<Dim>(map), digest) << "saving changed the map";
    for (const auto type : {StorageType::blockGrid, StorageType::tree}) {
        const auto copy = makeStorage<Dim>(type, geometry);
        copy->setLogOdds({}, 3.0f);  // goes away
        decodeCells<Dim>(bytes.data(), bytes.size(), *copy);
        EXPECT_TRUE(equalsOracle<Dim>(*copy, cells));
        EXPECT_TRUE(saturationEquals<Dim>(*copy, cells, SensorModel().min()));
        EXPECT_EQ(contentDigest<Dim>(*copy), digest);
        EXPECT_EQ(encodeCells<Dim>(*copy), bytes) << "bytes depend on the storage type";
    }
}

TYPED_TEST(CellsOfStorage, EmptyMap) {
    constexpr int Dim = TypeParam::Dim;
    typename TypeParam::Map map(CellGeometry<Dim>(0.05)), copy(CellGeometry<Dim>(0.05));
    const auto bytes = encodeCells<Dim>(map);
    copy.setLogOdds({}, 3.0f);
    decodeCells<Dim>(bytes.data(), bytes.size(), copy);
    EXPECT_TRUE(copy.empty());
}

TYPED_TEST(CellsOfStorage, WrongDimensionOrResolutionIsRefused) {
    constexpr int Dim = TypeParam::Dim;
    constexpr int Other = 5 - Dim;
    typename TypeParam::Map map(CellGeometry<Dim>(0.05));
    map.setLogOdds({}, 3.0f);
    const auto bytes = encodeCells<Dim>(map);
    BlockGrid<Other> otherDimension(CellGeometry<Other>(0.05));
    EXPECT_THROW(decodeCells<Other>(bytes.data(), bytes.size(), otherDimension), MapFileError);
    BlockGrid<Dim> otherResolution(CellGeometry<Dim>(0.1));
    EXPECT_THROW(decodeCells<Dim>(bytes.data(), bytes.size(), otherResolution), MapFileError);
}

class MapFileOnDisk : public ::testing::Test {
 protected:
    TemporaryFolder folder;
    const std::string path = folder.path + "/map.srmap";
    const MapFileHeader header{"CSuperRayGridMap3D", 3, 0.05, "[options]\nx = 1\n"};
    BlockGrid<3> map{CellGeometry<3>(0.05)};
    std::vector<std::uint8_t> cells;

    MapFileOnDisk() {
        fillRandomly<3>(map, 1);
        cells = encodeCells<3>(map);
    }
    void expectIntact() const {
        const MapFile file = loadMapFile(path);
        EXPECT_EQ(file.header.className, header.className);
        EXPECT_EQ(file.header.dimension, header.dimension);
        EXPECT_EQ(file.header.resolution, header.resolution);
        EXPECT_EQ(file.header.options, header.options);
        EXPECT_EQ(file.cells, cells);
        EXPECT_EQ(folder.entries(), 1) << "a temporary file is left";
    }
};

TEST_F(MapFileOnDisk, RoundTrip) {
    saveMapFile(path, header, cells);
    expectIntact();
    saveMapFile(path, header, cells);  // over the old one
    expectIntact();
}

TEST_F(MapFileOnDisk, FailedSaveLeavesTheOldFile) {
    saveMapFile(path, header, cells);
    const auto larger = std::vector<std::uint8_t>(1 << 20, 7);
    // A full disk, as far as this process can tell.
    struct rlimit before {};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const struct rlimit limit = {4096, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
    EXPECT_THROW(saveMapFile(path, header, larger), MapFileError);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    std::signal(SIGXFSZ, handler);
    expectIntact();
}

TEST_F(MapFileOnDisk, UnusableResolutionsAreRefused) {
    saveMapFile(path, header, cells);
    for (const double resolution : {0.0, -1.0, 1e-310, 9e-7, 1.1e6, 1e300, std::nan("")}) {
        MapFileHeader wrong = header;
        wrong.resolution = resolution;
        EXPECT_THROW(saveMapFile(path, wrong, cells), MapFileError) << resolution;
        EXPECT_THROW(CellGeometry<3>{resolution}, std::invalid_argument) << resolution;
    }
    expectIntact();
}

TEST_F(MapFileOnDisk, UnusablePathsAreRefused) {
    EXPECT_THROW(saveMapFile(folder.path + "/none/map.srmap", header, cells), MapFileError);
    EXPECT_THROW(saveMapFile(folder.path, header, cells), MapFileError) << "a directory";
    EXPECT_THROW(saveMapFile("/dev/full", header, cells), MapFileError) << "a full device";
    EXPECT_THROW(loadMapFile(folder.path + "/none"), MapFileError);
    EXPECT_THROW(loadMapFile(folder.path), MapFileError);
    const std::string fifo = folder.path + "/fifo";
    ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
    EXPECT_THROW(loadMapFile(fifo), MapFileError);
    EXPECT_EQ(folder.entries(), 1) << "only the FIFO";
}

TEST_F(MapFileOnDisk, SymbolicLinkIsFollowed) {
    saveMapFile(path, header, {});
    const std::string link = folder.path + "-link";
    ASSERT_EQ(::symlink(path.c_str(), link.c_str()), 0);
    saveMapFile(link, header, cells);
    expectIntact();
    EXPECT_EQ(::unlink(link.c_str()), 0);
}

TEST_F(MapFileOnDisk, InvalidHeadersAreRefused) {
    for (const MapFileHeader& bad :
         {MapFileHeader{"", 3, 0.05, ""}, MapFileHeader{"C", 4, 0.05, ""},
          MapFileHeader{"C", 3, 0, ""}, MapFileHeader{"C", 3, -1, ""},
          MapFileHeader{"C", 3, std::nan(""), ""}})
        EXPECT_THROW(saveMapFile(path, bad, cells), MapFileError);
    EXPECT_EQ(folder.entries(), 0);
}

TEST_F(MapFileOnDisk, ErrorNamesFileAndRule) {
    saveMapFile(path, header, cells);
    auto bytes = contentsOf(path);
    bytes.resize(bytes.size() - 1);
    try {
        parseMapFile(bytes.data(), bytes.size(), "broken.srmap");
        FAIL() << "no error";
    } catch (const MapFileError& e) {
        EXPECT_NE(std::string(e.what()).find("broken.srmap"), std::string::npos) << e.what();
        EXPECT_NE(std::string(e.what()).find(std::to_string(bytes.size())), std::string::npos)
            << e.what();
    }
}

TEST_F(MapFileOnDisk, SectionRules) {
    const auto section = [](const std::string& tag) {
        return std::pair<std::string, std::vector<std::uint8_t>>(tag, {1, 2, 3});
    };
    saveMapFile(path, header, cells);
    const auto good = contentsOf(path);
    const auto sections = sectionsOf(good);
    ASSERT_EQ(sections.size(), 3u);
    ASSERT_EQ(containerOf(sections), good) << "the test knows the format";

    auto extended = sections;
    extended.insert(extended.begin() + 1, section("NEWS"));
    extended.push_back(section("NEWS"));
    const auto bytes = containerOf(extended);
    EXPECT_EQ(parseMapFile(bytes.data(), bytes.size(), "x").cells, cells) << "unknown: skipped";

    for (std::size_t s = 0; s < 3; ++s) {
        auto missing = sections, twice = sections;
        missing.erase(missing.begin() + static_cast<std::ptrdiff_t>(s));
        twice.push_back(sections[s]);
        for (const auto& bad : {containerOf(missing), containerOf(twice)})
            EXPECT_THROW(parseMapFile(bad.data(), bad.size(), "x"), MapFileError);
    }
    auto version2 = good;
    version2[8] = 2;
    EXPECT_THROW(parseMapFile(version2.data(), version2.size(), "x"), MapFileError);
}

TEST_F(MapFileOnDisk, EmptyOptionsAndCellsAreReadBack) {
    MapFileHeader bare = header;
    bare.options.clear();
    saveMapFile(path, bare, cells);
    EXPECT_EQ(loadMapFile(path).header.options, "");
    EXPECT_EQ(loadMapFile(path).cells, cells);
    saveMapFile(path, bare, {});
    EXPECT_TRUE(loadMapFile(path).cells.empty());
}

TEST_F(MapFileOnDisk, SizesAreComparedBeforeTheFileIsRead) {
    const auto errorOf = [&](const MapFileLimits& limits) -> std::string {
        try {
            loadMapFile(path, limits);
        } catch (const MapFileError& e) {
            return e.what();
        }
        return "no error";
    };
    saveMapFile(path, header, cells);
    const auto size = std::filesystem::file_size(path);
    EXPECT_EQ(errorOf({size, 0}), "no error");
    EXPECT_NE(errorOf({size - 1, 0}).find("the limit is"), std::string::npos);
    // A hole of a terabyte behind a good beginning: there is no memory for it.
    std::filesystem::resize_file(path, std::uintmax_t{1} << 40);
    EXPECT_NE(errorOf(MapFileLimits::ofThisMachine()).find("not the declared"),
              std::string::npos);
    std::ofstream(path) << "text";
    std::filesystem::resize_file(path, std::uintmax_t{1} << 40);
    EXPECT_NE(errorOf(MapFileLimits::ofThisMachine()).find("not a superray map file"),
              std::string::npos);
}

TEST_F(MapFileOnDisk, MemoryIsLimitedBeforeCellsAreMade) {
    Octree target(CellGeometry<3>(0.05));
    EXPECT_THROW(decodeCells<3>(cells.data(), cells.size(), target, {0, 1000}), MapFileError);
    EXPECT_TRUE(target.empty());
    decodeCells<3>(cells.data(), cells.size(), target, {0, 64 << 20});
    EXPECT_FALSE(target.empty());
    ASSERT_EQ(::setenv("SUPERRAY_MAP_MEGABYTES", "3", 1), 0);
    EXPECT_EQ(MapFileLimits::ofThisMachine().mapBytes, 3u << 20);
    ASSERT_EQ(::unsetenv("SUPERRAY_MAP_MEGABYTES"), 0);
    EXPECT_GT(MapFileLimits::ofThisMachine().mapBytes, 64u << 20);
}

}  // namespace
}  // namespace superray::test
