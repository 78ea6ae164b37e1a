// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/engine_weights.h>

#include <cmath>
#include <cstdio>

namespace superray {
namespace {

constexpr int kCrossed = 10, kEnd = 20;  // cells of the line along x
constexpr int kRaysOfScan = 300;         // more than any policy tells apart
constexpr int kScans = 200;              // more than any engine takes to a clamp

/// The middle of cell i of the line.
Eigen::Vector3f middleOf(int i, double resolution) {
    const auto edge = static_cast<float>(resolution);
    return {(static_cast<float>(i) + 0.5f) * edge, 0.5f * edge, 0.5f * edge};
}

struct Pair {
    double crossed, end;  // log-odds of the two cells
};

/// The two cells after so many equal scans of so many equal rays.
Pair insertRays(const BenchEngineInfo& info, const BenchEngineOptions& options, int scans,
                int raysOfScan) {
    const auto engine = info.make(options);
    PointScan scan;
    scan.origin = middleOf(0, options.resolution);
    scan.points.assign(static_cast<std::size_t>(raysOfScan),
                       middleOf(kEnd, options.resolution));
    for (int i = 0; i < scans; ++i) {
        engine->prepare(scan);
        engine->insert();
    }
    const auto logOdds = [&](int cell) {
        const double p = engine->occupancy(middleOf(cell, options.resolution)).value_or(0.5);
        return std::log(p / (1 - p));
    };
    return {logOdds(kCrossed), logOdds(kEnd)};
}

}  // namespace

EngineWeights weightsOf(const BenchEngineInfo& info, BenchEngineOptions options) {
    options.bounds = Eigen::AlignedBox3f(middleOf(0, options.resolution),
                                         middleOf(kEnd, options.resolution));
    options.threads = 1;
    options.reserveMegabytes = 0;
    const Pair ray = insertRays(info, options, 1, 1);
    const Pair scan = insertRays(info, options, 1, kRaysOfScan);
    const Pair all = insertRays(info, options, kScans, 1);
    return {ray.end, ray.crossed, scan.end, scan.crossed, all.crossed, all.end};
}

std::string describe(const EngineWeights& w) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "hit %+.2f, miss %+.3f; a scan at most %+.2f, %+.2f; from %.2f to %.2f "
                  "(log-odds)",
                  w.hit, w.miss, w.scanHit, w.scanMiss, w.lowest, w.highest);
    return text;
}

bool sameWeights(const EngineWeights& a, const EngineWeights& b) {
    const auto same = [](double x, double y) { return std::abs(x - y) < 1e-3; };
    return same(a.hit, b.hit) && same(a.miss, b.miss) && same(a.scanHit, b.scanHit) &&
           same(a.scanMiss, b.scanMiss) && same(a.lowest, b.lowest) &&
           same(a.highest, b.highest);
}

}  // namespace superray
