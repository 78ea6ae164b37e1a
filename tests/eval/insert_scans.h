// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <superray/eval/scan_source.h>
#include <superray/maps/CSuperRayGridMap3D.h>

#include <exception>

namespace superray::test {

/// Inserts all scans into a coarse map; those that cannot be are left out (e.g. their pose is
/// not finite).
inline void insertWhatCanBe(ScanSource& source) {
    CSuperRayGridMap3D map(0.5);
    map.insertionOptions.maxrange = 30;
    while (const auto scan = source.next()) {
        try {
            map.insertObservation(*scan->observation, scan->T_map_robot);
        } catch (const std::exception&) {
        }
    }
}

}  // namespace superray::test
