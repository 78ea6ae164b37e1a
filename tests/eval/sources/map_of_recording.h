// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A recording into a map, and what the map says of a point.

#include <superray/eval/map_build.h>

#include <limits>
#include <optional>

namespace superray::test {

inline BuildReport buildInto(mrpt::maps::CMetricMap& map, const std::string& path,
                             const ScanSourceOptions& options = {}) {
    ScanSources sources;
    sources.push_back(openScanSource(path, options));
    return buildMap(sources, map, std::numeric_limits<std::uint64_t>::max(),
                    [](const BuildProgress&) {});
}

/// Nothing if nothing is known of the point.
inline std::optional<bool> occupied(const SuperRayMapInterface& map, double x, double y,
                                    double z = 0) {
    if (!map.occupancyAt({x, y, z})) return std::nullopt;
    return map.isOccupied({x, y, z});
}

}  // namespace superray::test
