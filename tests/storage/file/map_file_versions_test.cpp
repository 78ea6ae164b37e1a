// SPDX-License-Identifier: BSD-3-Clause
// Files of every format version there was are read for ever: one per dimension
// is kept, and must give the cells written here.

#include <cstdlib>

#include "storage/file/map_file_tools.h"

namespace superray::test {
namespace {

const std::string kOptions = "[insertOpts]\nresolution = 0.1\n";

/// A uniform, a dense and two sparse blocks, one at each addressable limit.
template <int Dim>
Cells<Dim> cellsOfVersion1() {
    Cells<Dim> cells;
    for (int i = 0; i < kBlockCells<Dim>; ++i) {
        BlockKey<Dim> key{};
        cells[cellInBlock<Dim>(key, i)] = SensorModel().min();
        key[0] = -1;
        if (i % 3) cells[cellInBlock<Dim>(key, i)] = 0.125f * static_cast<float>(i % 29) - 1.5f;
    }
    Cell<Dim> lowest, highest;
    lowest.fill(-kCellLimit);
    highest.fill(kCellLimit - 1);
    cells[lowest] = 0.0f;
    cells[highest] = 3.5f;
    return cells;
}

template <int Dim>
void loadsAsWritten(const std::string& name, const std::string& className) {
    const std::string path = std::string(SUPERRAY_TEST_DATA_DIR) + "/" + name;
    const Cells<Dim> cells = cellsOfVersion1<Dim>();
    // How the kept file was made; for a new format version add a new one.
    if (std::getenv("SUPERRAY_WRITE_TEST_DATA")) {
        BlockGrid<Dim> map(CellGeometry<Dim>(0.1));
        for (const auto& [cell, value] : cells) map.setLogOdds(cell, value);
        saveMapFile(path, {className, Dim, 0.1, kOptions}, encodeCells<Dim>(map));
    }
    const MapFile file = loadMapFile(path);
    EXPECT_EQ(file.header.className, className);
    EXPECT_EQ(file.header.dimension, Dim);
    EXPECT_EQ(file.header.resolution, 0.1);
    EXPECT_EQ(file.header.options, kOptions);
    for (const auto type : {StorageType::blockGrid, StorageType::tree}) {
        const auto map = makeStorage<Dim>(type, CellGeometry<Dim>(0.1));
        decodeCells<Dim>(file.cells.data(), file.cells.size(), *map);
        EXPECT_TRUE(equalsOracle<Dim>(*map, cells));
    }
}

TEST(MapFileVersions, Version1In3D) {
    loadsAsWritten<3>("format_v1_3d.srmap", "CSuperRayGridMap3D");
}
TEST(MapFileVersions, Version1In2D) {
    loadsAsWritten<2>("format_v1_2d.srmap", "CSuperRayGridMap2D");
}

}  // namespace
}  // namespace superray::test
