// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_request.h
/// A map made from what a user asks for: a configuration file, and single
/// options that override it.

#include <mrpt/maps/CMetricMap.h>

#include <cstdint>
#include <optional>
#include <string>

namespace superray {

/// What is not given keeps the value of the configuration file, or the default.
struct MapRequest {
    std::optional<std::string> className;  ///< default CSuperRayGridMap3D
    std::string configFile;                ///< .ini; empty: none
    /// Section of configFile: either a multi-metric-map section that defines
    /// one of our maps (`superRayGridMap3D_count = 1`), or the prefix of the
    /// sections of one map (`<section>_creationOpts`, `<section>_insertOpts`, ...).
    std::string section;
    std::optional<double> resolution;                 ///< [m]
    std::optional<double> maxRange, minRange;         ///< [m]
    std::optional<double> windowRadius;               ///< [m], see TInsertionOptions
    std::optional<std::uint32_t> maxMemoryMegabytes;  ///< see TCreationOptions
    std::optional<std::string> policy;                ///< see updatePolicyFromString()
    std::optional<std::string> method;                ///< see methodFromString()
    std::optional<std::string> sensorLabels;          ///< comma-separated
    std::optional<std::uint32_t> threads;
};

/// \throws InputError, std::invalid_argument: unreadable file, missing section,
///         unknown keys, values out of their range
mrpt::maps::CMetricMap::Ptr makeMap(const MapRequest& request);

}  // namespace superray
