// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What settles a cell, by sensor model, policy and the values in the map.

#include <superray/core/saturation_source.h>
#include <superray/core/sensor_model.h>

#include <array>
#include <cstdint>

namespace superray {

/// Numbers of misses and hits of one scan beyond which more misses change nothing.
struct SaturationLimits {
    SaturationLimits() = default;
    /// \param values bounds of the values in the map
    SaturationLimits(const SensorModel& model, UpdatePolicy policy, LogOddsRange values);

    float lowerClamp = 0;               ///< log-odds of a cell that is saturated free
    std::uint32_t misses = 1;           ///< settle any cell that is not hit
    std::uint32_t missesOfUnknown = 1;  ///< ... that is not above 0
    std::uint32_t hits = 1;             ///< settle a cell, however often it is missed

    /// Policy netEvidence: hits and misses of a cell act together. So a cell at the lower
    /// clamp is not settled if the scan hits it, and how many misses settle a cell depends on
    /// its hits: missesBesideHits[h], for h >= 1. They do not depend on the map.
    bool hitsUnsettle = false;
    std::array<std::uint8_t, SensorModel::kMostCounted + 1> missesBesideHits{};
};

}  // namespace superray
