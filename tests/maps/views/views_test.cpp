// SPDX-License-Identifier: BSD-3-Clause
// What other programs see of a map: voxels, OctoMap files, PLY, pictures.

#include <mrpt/img/CImage.h>
#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <octomap/OcTree.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayQuadMap.h>
#include <superray/maps/mrpt_compat.h>

#include <fstream>
#include <map>
#include <set>
#include <tuple>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::opengl::COctoMapVoxels;
using mrpt::opengl::VOXEL_SET_FREESPACE;
using mrpt::opengl::VOXEL_SET_OCCUPIED;

template <class Map>
void fill(Map& map) {
    map.insertionOptions.setPolicy(UpdatePolicy::everyRay);  // frees more than it occupies
    for (unsigned i = 0; i < 2; ++i)
        ASSERT_TRUE(map.insertObservation(*test::randomCloud(500, i), test::someRobotPose()));
}

COctoMapVoxels::Ptr voxelsOf(const mrpt::maps::CMetricMap& map) {
    mrpt::opengl::CSetOfObjects objects;
    map.getVisualizationInto(objects);
    return objects.getByClass<COctoMapVoxels>();
}

template <class Map>
void expectVoxelsLikeTheCells() {
    Map map(0.2);
    fill(map);
    const auto cells = map.cellTotals();
    ASSERT_GT(cells.occupied, 100u);
    ASSERT_GT(cells.free, cells.occupied);
    EXPECT_EQ(cells.known, cells.occupied + cells.free);
    auto voxels = voxelsOf(map);
    ASSERT_TRUE(voxels);
    EXPECT_EQ(voxels->getVoxelCount(VOXEL_SET_OCCUPIED), cells.occupied);
    EXPECT_EQ(voxels->getVoxelCount(VOXEL_SET_FREESPACE), 0u) << "off by default";
    EXPECT_EQ(voxels->getGridCubeCount(), 0u);
    for (std::size_t i = 0; i < cells.occupied; ++i) {
        const auto& v = voxels->getVoxel(VOXEL_SET_OCCUPIED, i);
        EXPECT_EQ(v.side_length, 0.2);
        Point<3> p(v.coords.x, v.coords.y, v.coords.z);
        const auto c = CellGeometry<3>(0.2).cellOf(p);
        std::optional<float> value;
        if constexpr (std::is_base_of_v<CSuperRayMapBase<3>, Map>) {
            value = map.storage().logOdds(c);
        } else {
            EXPECT_EQ(v.coords.z, 0);
            value = map.storage().logOdds({c[0], c[1]});
        }
        ASSERT_TRUE(value);
        EXPECT_GE(*value, map.sensorModel().occupied());
    }

    map.renderingOptions.generateFreeVoxels = true;
    map.renderingOptions.visibleFreeVoxels = false;
    map.renderingOptions.generateGridLines = true;
    map.renderingOptions.colour = VoxelColour::occupancy;
    voxels = voxelsOf(map);
    EXPECT_EQ(voxels->getVoxelCount(VOXEL_SET_FREESPACE), cells.free);
    EXPECT_EQ(voxels->getGridCubeCount(), cells.known);
    EXPECT_FALSE(voxels->areVoxelsVisible(VOXEL_SET_FREESPACE));
    EXPECT_TRUE(voxels->areVoxelsVisible(VOXEL_SET_OCCUPIED));

    map.genericMapParams.enableSaveAs3DObject = false;
    EXPECT_FALSE(voxelsOf(map));
}

TEST(Voxels, AreTheCells) {
    expectVoxelsLikeTheCells<CSuperRayGridMap3D>();
    expectVoxelsLikeTheCells<CSuperRayOctoMap>();
    expectVoxelsLikeTheCells<CSuperRayGridMap2D>();
    expectVoxelsLikeTheCells<CSuperRayQuadMap>();
}

TEST(Voxels, ColourFollowsHeight) {
    CSuperRayGridMap3D map(0.2);
    fill(map);
    const auto voxels = voxelsOf(map);
    std::map<float, std::set<std::tuple<int, int, int>>> colours;
    for (std::size_t i = 0; i < voxels->getVoxelCount(VOXEL_SET_OCCUPIED); ++i) {
        const auto& v = voxels->getVoxel(VOXEL_SET_OCCUPIED, i);
        colours[v.coords.z].insert({v.color.R, v.color.G, v.color.B});
    }
    ASSERT_GT(colours.size(), 10u);
    for (const auto& [z, set] : colours) EXPECT_EQ(set.size(), 1u) << z;
    EXPECT_NE(*colours.begin()->second.begin(), *colours.rbegin()->second.begin());
}

TEST(Voxels, FollowTheContentsAndAreTheCallersOwn) {
    CSuperRayGridMap3D map(0.2);
    EXPECT_EQ(voxelsOf(map)->getVoxelCount(VOXEL_SET_OCCUPIED), 0u);
    fill(map);
    const auto first = voxelsOf(map);
    first->clear();  // a caller may do what he likes with his copy
    EXPECT_EQ(voxelsOf(map)->getVoxelCount(VOXEL_SET_OCCUPIED), map.cellTotals().occupied);
    ASSERT_TRUE(map.insertObservation(*test::randomCloud(500, 77)));
    EXPECT_EQ(voxelsOf(map)->getVoxelCount(VOXEL_SET_OCCUPIED), map.cellTotals().occupied);
    map.clear();
    EXPECT_EQ(voxelsOf(map)->getVoxelCount(VOXEL_SET_OCCUPIED), 0u);
}

/// All leaves of a tree as cells of the finest level.
std::map<Cell<3>, float> cellsOf(const octomap::OcTree& tree) {
    std::map<Cell<3>, float> cells;
    for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
        const int edge = 1 << (tree.getTreeDepth() - leaf.getDepth());
        const auto key = leaf.getIndexKey();
        for (int x = 0; x < edge; ++x)
            for (int y = 0; y < edge; ++y)
                for (int z = 0; z < edge; ++z)
                    cells[{key[0] + x - kCellLimit, key[1] + y - kCellLimit,
                           key[2] + z - kCellLimit}] = leaf->getLogOdds();
    }
    return cells;
}

template <class Map, class = void>
struct WritesOctomap : std::false_type {};
template <class Map>
struct WritesOctomap<
    Map, std::void_t<decltype(std::declval<const Map&>().exportOctomap(std::string()))>>
    : std::true_type {};
template <class Map, class = void>
struct WritesPicture : std::false_type {};
template <class Map>
struct WritesPicture<
    Map, std::void_t<decltype(std::declval<const Map&>().exportPicture(std::string()))>>
    : std::true_type {};

TEST(Exports, AreOnlyThereForTheDimensionThatTheySuit) {
    EXPECT_TRUE(WritesOctomap<CSuperRayGridMap3D>::value);
    EXPECT_TRUE(WritesOctomap<CSuperRayOctoMap>::value);
    EXPECT_FALSE(WritesOctomap<CSuperRayGridMap2D>::value);
    EXPECT_FALSE(WritesOctomap<SuperRayMapInterface>::value);
    EXPECT_TRUE(WritesPicture<CSuperRayGridMap2D>::value);
    EXPECT_FALSE(WritesPicture<CSuperRayGridMap3D>::value);
    EXPECT_FALSE(WritesPicture<SuperRayMapInterface>::value);
}

template <class Map>
void expectOctomapFilesLikeTheMap() {
    const test::TempFolder folder;
    Map map(0.2);
    map.insertionOptions.occupancyThres = 0.6;
    fill(map);
    ASSERT_TRUE(map.insertObservation(*test::randomCloud(500, 1), test::someRobotPose()));
    map.exportOctomap(folder.file("map.ot"));
    map.exportOctomap(folder.file("map.bt"));
    const std::unique_ptr<octomap::AbstractOcTree> read(
        octomap::AbstractOcTree::read(folder.file("map.ot")));
    const auto* full = dynamic_cast<octomap::OcTree*>(read.get());
    ASSERT_TRUE(full);
    EXPECT_EQ(full->getResolution(), 0.2);
    octomap::OcTree binary(0.1);
    ASSERT_TRUE(binary.readBinary(folder.file("map.bt")));
    EXPECT_EQ(binary.getResolution(), 0.2);
    const auto values = cellsOf(*full), bits = cellsOf(binary);
    ASSERT_EQ(values.size(), map.cellTotals().known);
    ASSERT_EQ(bits.size(), map.cellTotals().known);
    std::size_t occupied = 0;
    for (const auto& [cell, value] : values) {
        const auto stored = map.storage().logOdds(cell);
        ASSERT_TRUE(stored);
        EXPECT_EQ(*stored, value);
        const bool isOccupied = *stored >= map.sensorModel().occupied();
        EXPECT_EQ(bits.at(cell) > 0, isOccupied);
        occupied += isOccupied ? 1 : 0;
    }
    EXPECT_EQ(occupied, map.cellTotals().occupied);
    EXPECT_THROW(map.exportOctomap(folder.file("map.txt")), std::invalid_argument);
    EXPECT_THROW(map.exportOctomap(folder.file("no/folder/map.ot")), std::runtime_error);
    EXPECT_THROW(map.exportOctomap(folder.file("no/folder/map.bt")), std::runtime_error);
}

TEST(OctomapFiles, HoldTheCells) {
    expectOctomapFilesLikeTheMap<CSuperRayGridMap3D>();
    expectOctomapFilesLikeTheMap<CSuperRayOctoMap>();
}

TEST(OctoMap, GivesItsTree) {
    CSuperRayOctoMap map(0.2);
    fill(map);
    const octomap::OcTree& tree = map.octree();
    EXPECT_EQ(cellsOf(tree).size(), map.cellTotals().known);
    const auto point =
        CellGeometry<3>(0.2).center(CellGeometry<3>(0.2).cellOf(Point<3>(1.5, -2.25, 1.8)));
    const auto* node = tree.search(point.x(), point.y(), point.z());
    const auto value = map.storage().logOdds(CellGeometry<3>(0.2).cellOf(point));
    EXPECT_EQ(node != nullptr, value.has_value());
}

TEST(Ply, HasTheOccupiedCells) {
    const test::TempFolder folder;
    CSuperRayGridMap3D map(0.2);
    fill(map);
    map.exportPly(folder.file("map.ply"));
    std::ifstream file(folder.file("map.ply"), std::ios::binary);
    std::string line;
    std::size_t vertices = 0;
    while (std::getline(file, line) && line != "end_header")
        if (line.rfind("element vertex ", 0) == 0) vertices = std::stoul(line.substr(15));
    EXPECT_EQ(vertices, map.cellTotals().occupied);
    std::vector<float> values(4 * vertices);
    file.read(reinterpret_cast<char*>(values.data()),
              static_cast<std::streamsize>(values.size() * sizeof(float)));
    ASSERT_TRUE(file);
    EXPECT_EQ(file.peek(), std::ifstream::traits_type::eof());
    for (std::size_t i = 0; i < vertices; ++i) {
        const Point<3> p(values[4 * i], values[4 * i + 1], values[4 * i + 2]);
        const auto value = map.storage().logOdds(map.storage().geometry().cellOf(p));
        ASSERT_TRUE(value);
        EXPECT_NEAR(values[4 * i + 3], probabilityOf(*value), 1e-6);
        EXPECT_GE(values[4 * i + 3], 0.5);
    }
    EXPECT_THROW(map.exportPly(folder.file("no/map.ply")), std::runtime_error);
}

TEST(Picture, HasOnePixelPerCell) {
    const test::TempFolder folder;
    CSuperRayGridMap2D map(0.1);
    fill(map);
    map.exportPicture(folder.file("map.png"));
    mrpt::img::CImage image;
    ASSERT_TRUE(image.loadFromFile(folder.file("map.png"), 0));
    const auto s = map.summary();
    ASSERT_EQ(image.getWidth(), static_cast<std::size_t>(s.highest[0] - s.lowest[0] + 1));
    ASSERT_EQ(image.getHeight(), static_cast<std::size_t>(s.highest[1] - s.lowest[1] + 1));
    std::size_t black = 0, white = 0;
    for (int y = s.lowest[1]; y <= s.highest[1]; ++y)
        for (int x = s.lowest[0]; x <= s.highest[0]; ++x) {
            const auto grey = image.at<std::uint8_t>(static_cast<unsigned>(x - s.lowest[0]),
                                                     static_cast<unsigned>(s.highest[1] - y));
            const auto value = map.storage().logOdds({x, y});
            const int expected = !value                                   ? 205
                                 : *value >= map.sensorModel().occupied() ? 0
                                                                          : 254;
            EXPECT_EQ(int{grey}, expected);
            black += grey == 0 ? 1 : 0;
            white += grey == 254 ? 1 : 0;
        }
    EXPECT_EQ(black, s.occupied);
    EXPECT_EQ(white, s.free);
}

TEST(Representation, WritesAllFiles) {
    const test::TempFolder folder;
    for (const auto& className : mapClassNames()) {
        const auto map = createMap(className);
        test::interfaceOf(*map).setResolution(0.2);
        ASSERT_TRUE(map->insertObservation(*test::randomCloud(500, 1)));
        map->genericMapParams.enableSaveAs3DObject = false;  // the file is asked for
        map->saveMetricMapRepresentationToFile(folder.file(className));
        const bool is3D = test::interfaceOf(*map).dimension() == 3;
        for (const std::string extension : {".srmap", ".3Dscene", ".bt", ".ot", ".png"}) {
            const bool expected = extension == ".srmap" || extension == ".3Dscene" ||
                                  (extension == ".png") != is3D;
            EXPECT_EQ(std::filesystem::exists(folder.file(className + extension)), expected)
                << className << extension;
        }
        EXPECT_EQ(test::interfaceOf(*loadMap(folder.file(className + ".srmap"))).digest(),
                  test::interfaceOf(*map).digest());
        GlScene scene;
        ASSERT_TRUE(scene.loadFromFile(folder.file(className + ".3Dscene")));
        const auto voxels = scene.getByClass<COctoMapVoxels>();
        ASSERT_TRUE(voxels);
        EXPECT_EQ(voxels->getVoxelCount(VOXEL_SET_OCCUPIED),
                  test::interfaceOf(*map).cellTotals().occupied);
    }
}

TEST(Representation, EmptyMapsCanBeSavedToo) {
    const test::TempFolder folder;
    for (const auto& className : mapClassNames()) {
        EXPECT_NO_THROW(
            createMap(className)->saveMetricMapRepresentationToFile(folder.file(className)));
        EXPECT_TRUE(loadMap(folder.file(className + ".srmap"))->isEmpty());
    }
}

}  // namespace
}  // namespace superray
