// SPDX-License-Identifier: BSD-3-Clause
#include "counting/saturation_limits.h"

#include <algorithm>

namespace superray {
namespace {

/// Fewest misses from which on more change nothing, in a cell that is hit so often.
std::uint8_t missesToSettle(const SensorModel& model, std::uint32_t hits) {
    const float settled = model.evidence(SensorModel::kMostCounted, hits);
    // The evidence does not grow with the number of misses: bisect.
    std::uint32_t from = 0, to = SensorModel::kMostCounted;
    while (from < to) {
        const std::uint32_t middle = (from + to) / 2;
        if (model.evidence(middle, hits) == settled)
            to = middle;
        else
            from = middle + 1;
    }
    return static_cast<std::uint8_t>(to);
}

}  // namespace

SaturationLimits::SaturationLimits(const SensorModel& model, UpdatePolicy policy,
                                   LogOddsRange values)
    : lowerClamp(model.min()) {
    switch (policy) {
        case UpdatePolicy::oncePerScan:
            return;
        case UpdatePolicy::everyRay:
            misses = model.missesToSaturate(std::max(model.max(), values.highest));
            missesOfUnknown = model.missesToSaturateUnknown();
            hits = model.hitsToSaturate(std::min(model.min(), values.lowest));
            return;
        case UpdatePolicy::netEvidence:
            break;
    }
    hitsUnsettle = true;
    misses = missesOfUnknown = missesToSettle(model, 0);
    // From this number of hits on, the scan says the same whatever the misses; the rest of
    // the table is 0.
    hits = 1;
    for (; hits <= SensorModel::kMostCounted; ++hits) {
        if (model.evidence(SensorModel::kMostCounted, hits) == model.scanHit()) break;
        missesBesideHits[hits] = missesToSettle(model, hits);
    }
}

}  // namespace superray
