// SPDX-License-Identifier: BSD-3-Clause
// 2D maps for other programs, read back by MRPT; maps of OctoMap, written by OctoMap.

#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/serialization/CArchive.h>
#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>
#include <superray/eval/input_error.h>
#include <superray/eval/map_output.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/map_factory.h>

#include <cmath>

#include "eval/temp_folder.h"

namespace superray {
namespace {

using test::messageOf;
using test::readWholeFile;
using test::TempFolder;

/// An L of walls, not symmetric in any way, away from the origin.
CSuperRayGridMap2D makePlan() {
    CSuperRayGridMap2D map(0.1);
    RayBundle<2> rays(CellGeometry<2>(0.1), {-3.05, 2.05});
    for (double a = 0; a < 3; a += 0.05) {
        rays.add({-5.05, 0.55 + a});
        rays.add({-5 + a / 2, 4.05});
    }
    map.insertRays(rays);
    return map;
}

/// Each known cell of the map against the grid that was read back.
void expectSame(const CSuperRayGridMap2D& map, const mrpt::maps::COccupancyGridMap2D& grid,
                double tolerance) {
    int occupied = 0, free = 0, unknown = 0, unknownInside = 0;
    for (int y = 0; y < 45; ++y)
        for (int x = -55; x < -25; ++x) {
            const double px = (x + 0.5) * 0.1, py = (y + 0.5) * 0.1;
            const auto p = map.occupancyAt({px, py, 0});
            const double there = grid.getPos(static_cast<float>(px), static_cast<float>(py));
            if (!p) {
                ++unknown;
                // MRPT takes the half cell beside its grid for the cell at the border.
                const bool isInside = px > grid.getXMin() && px < grid.getXMax() &&
                                      py > grid.getYMin() && py < grid.getYMax();
                if (isInside) {
                    EXPECT_NEAR(there, 0.5, 0.31) << px << " " << py;
                }
                unknownInside += isInside;
            } else if (tolerance > 0) {
                EXPECT_NEAR(there, 1 - *p, tolerance) << px << " " << py;
            } else {
                EXPECT_EQ(there < 0.5, map.isOccupied({px, py, 0})) << px << " " << py;
            }
            occupied += map.isOccupied({px, py, 0});
            free += p && !map.isOccupied({px, py, 0});
        }
    EXPECT_GT(occupied, 20);
    EXPECT_GT(free, 100);
    EXPECT_GT(unknown, 100);
    EXPECT_GT(unknownInside, 100);
}

TEST(Plan, isReadByMapServersReaderOfMrpt) {
    TempFolder folder;
    const auto map = makePlan();
    exportMap(map, folder / "plan.yaml");
    mrpt::maps::COccupancyGridMap2D grid;
    ASSERT_TRUE(grid.loadFromROSMapServerYAML(folder / "plan.yaml"));
    EXPECT_NEAR(grid.getResolution(), 0.1, 1e-6);
    expectSame(map, grid, 0);
    const auto yaml = readWholeFile(folder / "plan.yaml");
    EXPECT_NE(yaml.find("image: plan.pgm\n"), std::string::npos) << yaml;
    EXPECT_NE(yaml.find("resolution: 0.1\n"), std::string::npos) << yaml;
}

TEST(Plan, namesThatYamlWouldTakeForMoreAreQuoted) {
    TempFolder folder;
    const auto map = makePlan();
    const auto imageIn = [&](const std::string& name) {
        exportMap(map, folder / name);
        const auto yaml = readWholeFile(folder / name);
        return yaml.substr(0, yaml.find('\n'));
    };
    EXPECT_EQ(imageIn("a_b-2.yaml"), "image: a_b-2.pgm");
    EXPECT_EQ(imageIn("a: #b.yaml"), "image: 'a: #b.pgm'");
    EXPECT_EQ(imageIn("it's.yaml"), "image: 'it''s.pgm'");
    EXPECT_EQ(imageIn("[1].yaml"), "image: '[1].pgm'");
}

TEST(Plan, aPictureLeavesItsOriginBesideIt) {
    TempFolder folder;
    const auto map = makePlan();
    exportMap(map, folder / "plan.png");
    mrpt::maps::COccupancyGridMap2D grid;
    ASSERT_TRUE(grid.loadFromROSMapServerYAML(folder / "plan.yaml"));
    expectSame(map, grid, 0);
}

TEST(Plan, asGridmapKeepsTheProbabilities) {
    TempFolder folder;
    const auto map = makePlan();
    exportMap(map, folder / "plan.gridmap");
    mrpt::io::CFileGZInputStream file(folder / "plan.gridmap");
    mrpt::maps::COccupancyGridMap2D grid;
    mrpt::serialization::archiveFrom(file) >> grid;
    expectSame(map, grid, 0.02);  // MRPT keeps 8 bits
}

TEST(Plan, isOf2DMapsOnly) {
    TempFolder folder;
    for (const char* name : {"a.yaml", "a.gridmap"}) {
        const auto message =
            messageOf<InputError>([&] { exportMap(CSuperRayGridMap3D(0.1), folder / name); });
        EXPECT_NE(message.find("files hold 2D maps"), std::string::npos) << message;
    }
    exportMap(CSuperRayGridMap2D(0.1), folder / "empty.yaml");
    EXPECT_EQ(readWholeFile(folder / "empty.pgm").substr(0, 3), "P5\n");
}

TEST(OctomapInput, isAMapWhereverOneIsRead) {
    TempFolder folder;
    CSuperRayGridMap3D map(0.1);
    RayBundle<3> rays(CellGeometry<3>(0.1), {0.05, 0.05, 0.05});
    for (double a = -1; a < 1; a += 0.07) rays.add({2.05, a, 0.5 * a});
    map.insertRays(rays);
    exportMap(map, folder / "a.ot");
    exportMap(map, folder / "a.bt");
    const auto digestOf = [&](const std::string& name) {
        return dynamic_cast<const SuperRayMapInterface&>(*loadMap(folder / name)).digest();
    };
    EXPECT_EQ(digestOf("a.ot"), map.digest());
    const auto loaded = loadMap(folder / "a.bt");
    const auto& cells = dynamic_cast<const SuperRayMapInterface&>(*loaded);
    EXPECT_EQ(cells.shortClassName(), "CSuperRayOctoMap");
    EXPECT_EQ(cells.cellTotals().occupied, map.cellTotals().occupied);
    EXPECT_EQ(cells.cellTotals().free, map.cellTotals().free);

    CSuperRayGridMap3D started(0.5);
    TMapOptions options = started.options();
    options.creation.load_from = folder / "a.ot";
    started.setOptions(options);
    EXPECT_EQ(started.digest(), map.digest());
    EXPECT_EQ(started.resolution(), 0.1);
    CSuperRayGridMap2D plan;
    EXPECT_THROW(plan.loadFromFile(folder / "a.ot"), MapFileError);
}

TEST(OctomapInput, coloursAreDropped) {
    TempFolder folder;
    octomap::ColorOcTree coloured(0.1);
    octomap::OcTree plain(0.1);
    for (float x = -1; x < 1; x += 0.1f) {
        const octomap::point3d p(x, 0.5f * x, 0.3f);
        coloured.updateNode(p, x > 0);
        coloured.setNodeColor(p.x(), p.y(), p.z(), 10, 200, 30);
        plain.updateNode(p, x > 0);
    }
    coloured.updateInnerOccupancy();
    ASSERT_TRUE(coloured.write(folder / "coloured.ot"));
    ASSERT_TRUE(coloured.writeBinary(folder / "coloured.bt"));
    ASSERT_TRUE(plain.write(folder / "plain.ot"));
    ASSERT_TRUE(plain.writeBinary(folder / "plain.bt"));
    const auto digestOf = [&](const std::string& name) {
        return dynamic_cast<const SuperRayMapInterface&>(*loadMap(folder / name)).digest();
    };
    testing::internal::CaptureStderr();
    EXPECT_EQ(digestOf("coloured.ot"), digestOf("plain.ot"));
    EXPECT_NE(testing::internal::GetCapturedStderr().find("colours of the ColorOcTree"),
              std::string::npos);
    EXPECT_EQ(digestOf("coloured.bt"), digestOf("plain.bt"));
}

}  // namespace
}  // namespace superray
