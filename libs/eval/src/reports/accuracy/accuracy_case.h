// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file accuracy_case.h
/// Scans and truth of one input at one resolution, ready for any number of maps.

#include <superray/eval/accuracy.h>

namespace superray {

/// One input at one resolution.
struct AccuracyCase {
    const AccuracyRequest& request;
    const SimulatedWorld* world;  // nullptr for recordings
    double resolution;
    Eigen::AlignedBox3f bounds;       // of what is inserted
    std::vector<PointScan> inserted;  // what maps are made of
    std::vector<PointScan> exact;     // the same rays without noise, in worlds
    TrainTestSplit split;             // its training scans have become `inserted`
    std::vector<Eigen::Vector3f> originOfTest;
    std::vector<std::uint64_t> cellOfTest;
    std::vector<float> incidenceOfTest;  // NaN where not looked at; empty for recordings
    std::optional<WorldTruth> truth;
    Slice slice;
};

/// \param exact the same scans without noise; nullptr for recordings, as `world`
AccuracyCase makeCase(const AccuracyRequest& request, const PointScans& scans,
                      const PointScans* exact, const SimulatedWorld* world, double resolution);

/// Cells of the picture's slice of which the truth is known: from the world, or by most
/// of the test points in a cell.
std::vector<TrueCell> cellsOfSlice(const AccuracyCase& c);

}  // namespace superray
