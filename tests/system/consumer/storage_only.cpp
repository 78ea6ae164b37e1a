// SPDX-License-Identifier: BSD-3-Clause
#include <superray/storage/block_grid.h>
#include <superray/storage/octree.h>

#include <iostream>

int main() {
    const superray::CellGeometry<3> geometry(0.1);
    superray::Octree tree(geometry);
    superray::BlockGrid<3> grid(geometry);
    tree.setLogOdds({1, 2, 3}, 0.5f);
    grid.setLogOdds({1, 2, 3}, 0.5f);
    std::cout << (superray::contentDigest<3>(tree) == superray::contentDigest<3>(grid)
                      ? "equal\n"
                      : "different\n");
}
