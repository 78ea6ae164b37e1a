// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file accuracy_contenders.h
/// Which maps are compared.

#include <superray/eval/accuracy.h>

namespace superray {

/// A map to make: how, and what the report calls it.
struct Contender {
    const BenchEngineInfo* info;
    BenchEngineOptions options;
    AccuracyRow row;
};

/// \param resolution [m]
/// \param bounds of all scans
std::vector<Contender> contendersOf(const AccuracyRequest& request, double resolution,
                                    const Eigen::AlignedBox3f& bounds);

}  // namespace superray
