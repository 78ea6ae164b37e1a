// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What saturates a cell, by sensor model and policy.

#include <superray/core/sensor_model.h>

#include <cstdint>

namespace superray {

/// Numbers of misses and hits of one scan beyond which more change nothing.
struct SaturationLimits {
    SaturationLimits() = default;
    SaturationLimits(const SensorModel& model, UpdatePolicy policy) : lowerClamp(model.min()) {
        if (policy == UpdatePolicy::oncePerScan) return;
        misses = model.missesToSaturate();
        missesOfUnknown = model.missesToSaturateUnknown();
        hits = model.hitsToSaturate();
    }

    float lowerClamp = 0;               ///< log-odds of a cell that is saturated free
    std::uint32_t misses = 1;           ///< take any cell there
    std::uint32_t missesOfUnknown = 1;  ///< take a cell there that is not above 0
    std::uint32_t hits = 1;             ///< after these, misses do not matter either
};

}  // namespace superray
