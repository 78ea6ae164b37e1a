// SPDX-License-Identifier: BSD-3-Clause
// Every kind of output on a disk that fails or is full, and when its writer is killed:
// the old file or the new one, and an error if it is the old one.

#include <gtest/gtest.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <superray/eval/map_output.h>
#include <superray/eval/simulated_rawlog.h>
#include <superray/eval/trajectory.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayPointsMap.h>
#include <superray/maps/gzip_output.h>

#include <map>

#include "eval/temp_folder.h"
#include "storage/file/output_trials.h"

namespace superray {
namespace {

using test::OutputTrials;
using test::TempFolder;
using test::WriteOutput;

/// Walls of a room; the two differ in size.
template <int Dim>
void fillRoom(CSuperRayMapBase<Dim>& map, int which) {
    const double side = which == 0 ? 2.05 : 2.55;
    Point<Dim> origin = Point<Dim>::Constant(0.05);
    RayBundle<Dim> rays(CellGeometry<Dim>(map.resolution()), origin);
    for (double a = -side; a <= 2; a += 0.05)
        for (double z = 0.05; z <= 1; z += 0.1) {
            Point<Dim> end = Point<Dim>::Constant(z);
            end[0] = a;
            end[1] = side;
            rays.add(end);
            std::swap(end[0], end[1]);
            rays.add(end);
        }
    map.insertRays(rays);
}

mrpt::obs::CObservation2DRangeScan::Ptr scanOfRange(float metres) {
    constexpr std::size_t kRays = 181;
    auto scan = mrpt::obs::CObservation2DRangeScan::Create();
    scan->aperture = static_cast<float>(M_PI);
    scan->resizeScan(kRays);
    for (std::size_t i = 0; i < kRays; ++i) {
        scan->setScanRange(i, metres);
        scan->setScanRangeValidity(i, true);
    }
    return scan;
}

template <class Map>
const Map& room(int which) {
    static Map maps[2] = {Map(0.1), Map(0.1)};
    if (maps[which].isEmpty()) fillRoom(maps[which], which);
    return maps[which];
}

const CSuperRayPointsMap2D& pointsMap(int which) {
    static CSuperRayPointsMap2D maps[2];
    if (maps[which].isEmpty())
        maps[which].insertObservation(*scanOfRange(which == 0 ? 3.0f : 4.0f));
    return maps[which];
}

Trajectory trajectory(int which) {
    Trajectory result;
    for (int i = 0; i < 3000 + which; ++i)
        result.add(mrpt::Clock::fromDouble(1e9 + i), mrpt::poses::CPose3D(i, which, 0));
    return result;
}

mrpt::maps::CSimpleMap makeKeyFrames(int which) {
    mrpt::maps::CSimpleMap map;
    for (int i = 0; i < 20 + which; ++i) {
        const auto pose =
            mrpt::poses::CPose3DPDFGaussian::Create(mrpt::poses::CPose3D(i, 0, 0));
        const auto frame = mrpt::obs::CSensoryFrame::Create();
        frame->insert(scanOfRange(3));
        map.insert(pose, frame);
    }
    return map;
}

/// The observations hold the time when they were made.
const mrpt::maps::CSimpleMap& keyFrames(int which) {
    static const mrpt::maps::CSimpleMap maps[2] = {makeKeyFrames(0), makeKeyFrames(1)};
    return maps[which];
}

const SimulatedWorld& world() {
    static const SimulatedWorld indoor("indoor", 1);
    return indoor;
}

template <class Map>
WriteOutput exporter() {
    return [](const std::string& path, int which) {
        PictureOptions small;
        small.width = 300;
        small.height = 200;
        exportMap(room<Map>(which), path, small);
    };
}

/// MRPT's own way: the path without its extension is the prefix.
template <class Map>
WriteOutput representation(const Map& (*map)(int)) {
    return [map](const std::string& path, int which) {
        map(which).saveMetricMapRepresentationToFile(path.substr(0, path.rfind('.')));
    };
}

struct Kind {
    std::string file;
    WriteOutput write;
    std::vector<std::string> files;
};

const std::map<std::string, Kind>& kinds() {
    const auto saver = [](const std::string& path, int which) {
        room<CSuperRayOctoMap>(which).saveToFile(path);
    };
    const std::vector<std::string> files3 = {"m.srmap", "m.3Dscene", "m.bt", "m.ot"};
    const std::vector<std::string> files2 = {"m.srmap", "m.3Dscene", "m.png"};
    static const std::map<std::string, Kind> all = {
        {"srmap", {"m.srmap", saver, {}}},
        {"ot", {"m.ot", exporter<CSuperRayGridMap3D>(), {}}},
        {"bt", {"m.bt", exporter<CSuperRayOctoMap>(), {}}},
        {"ply", {"m.ply", exporter<CSuperRayGridMap3D>(), {}}},
        {"scene", {"m.3Dscene", exporter<CSuperRayGridMap3D>(), {}}},
        {"picture3D", {"m.png", exporter<CSuperRayGridMap3D>(), {}}},
        {"picture2D", {"m.png", exporter<CSuperRayGridMap2D>(), {"m.png", "m.yaml"}}},
        {"plan", {"m.yaml", exporter<CSuperRayGridMap2D>(), {"m.yaml", "m.pgm"}}},
        {"gridmap", {"m.gridmap", exporter<CSuperRayGridMap2D>(), {}}},
        {"tum",
         {"m.tum",
          [](const std::string& path, int which) { trajectory(which).saveTum(path); },
          {}}},
        {"simplemap",
         {"m.simplemap",
          [](const std::string& path, int which) { writeGzip(keyFrames(which), path); },
          {}}},
        {"rawlog",
         {"m.rawlog",
          [](const std::string& path, int which) {
              writeSimulatedRawlog(world(), 1 + static_cast<unsigned>(which), path);
          },
          {"m.rawlog", "m.tum"}}},
        {"mrpt3D", {"m.srmap", representation(room<CSuperRayGridMap3D>), files3}},
        {"mrptTree", {"m.srmap", representation(room<CSuperRayOctoMap>), files3}},
        {"mrpt2D", {"m.srmap", representation(room<CSuperRayGridMap2D>), files2}},
        {"mrptPoints", {"m.srmap", representation(pointsMap), files2}},
    };
    return all;
}

class Outputs : public ::testing::TestWithParam<std::string> {};

TEST_P(Outputs, AreWholeOrOld) {
    const TempFolder folder;
    const Kind& kind = kinds().at(GetParam());
    const OutputTrials trials(folder / "", kind.file, kind.write, kind.files);
    trials.expectUsable();
    trials.failEachCall();
    trials.fillDisk();
    trials.killWriters(static_cast<unsigned>(std::hash<std::string>()(GetParam())));
}

std::vector<std::string> names() {
    std::vector<std::string> result;
    for (const auto& kind : kinds()) result.push_back(kind.first);
    return result;
}

INSTANTIATE_TEST_SUITE_P(Kinds, Outputs, ::testing::ValuesIn(names()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace superray
