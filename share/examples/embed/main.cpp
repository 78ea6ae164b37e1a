// SPDX-License-Identifier: BSD-3-Clause
// Maps one scan of a wall, two metres in front of a robot at (1, 0, 0).
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <superray/maps/CSuperRayGridMap3D.h>

#include <iostream>

int main() {
    mrpt::obs::CObservationPointCloud scan;
    scan.pointcloud = mrpt::maps::CSimplePointsMap::Create();
    for (int i = -100; i < 100; ++i) scan.pointcloud->insertPoint(2.0f, i / 100.0f, 0.5f);

    superray::CSuperRayGridMap3D map(0.05);  // cells of 5 cm
    map.insertObservation(scan, mrpt::poses::CPose3D(1, 0, 0));
    std::cout << map.cellTotals().occupied << " cells occupied\n";
    map.saveToFile("wall.srmap");
}
