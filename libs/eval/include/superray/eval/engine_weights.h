// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file engine_weights.h
/// What an engine's probabilities really come to, found by inserting rays.

#include <superray/eval/bench_engine.h>

#include <string>

namespace superray {

/// Changes of a cell that was unknown, and where they end [log-odds].
struct EngineWeights {
    double hit = 0;       ///< one ray that ends in it
    double miss = 0;      ///< one ray that crosses it
    double scanHit = 0;   ///< 300 rays of one scan that end in it
    double scanMiss = 0;  ///< 300 rays of one scan that cross it
    double lowest = 0;    ///< after many scans that cross it
    double highest = 0;   ///< after many scans that end in it
};

/// Inserts rays along a line of cells into empty maps of the engine. The options count,
/// but for bounds, threads and reserved memory.
EngineWeights weightsOf(const BenchEngineInfo& info, BenchEngineOptions options);

/// "hit +0.85, miss -0.41; a scan at most +0.85, -0.41; from -2.00 to 3.51 (log-odds)"
std::string describe(const EngineWeights& weights);

/// True if they say the same, but for an engine's rounding.
bool sameWeights(const EngineWeights& a, const EngineWeights& b);

}  // namespace superray
