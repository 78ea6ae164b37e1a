// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file bench_scans.h
/// Small data for the tests of the benchmark.

#include <superray/eval/bench_compare.h>

#include "eval/recorded_scans.h"

namespace superray::test {

/// Three scans of 300 points, the robot moves.
inline std::string writeSmallRecording(const std::string& path) {
    Objects objects;
    for (int i = 0; i < 3; ++i) {
        objects.push_back(makePose(i, mrpt::poses::CPose3D(0.3 * i, 0, 0, 0.2 * i, 0, 0)));
        objects.push_back(makeCloud(i, static_cast<unsigned>(i), "LIDAR", 300));
    }
    return writeRawlog(path, objects);
}

/// The same in memory.
inline PointScans smallScans(const std::string& folder) {
    PointScanRequest request;
    request.data = writeSmallRecording(folder + "/small.rawlog");
    return loadPointScans(request);
}

}  // namespace superray::test
