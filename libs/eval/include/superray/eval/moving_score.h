// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file moving_score.h
/// What a map makes of a walker, and of a thing that is taken away.

#include <superray/eval/bench_engine.h>
#include <superray/eval/simulated_world.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace superray {

/// A map is taken to say "occupied" from p = 0.5 on. Cells that share a point with what
/// is fixed do not count.
struct MovingScore {
    /// Cells in which rays that met the walker ended; counted in the first such scan.
    std::uint64_t walkerCells = 0;
    std::uint64_t detected = 0;  ///< those said occupied right after that scan
    /// The same, counted by rays: a cell at the walker's outline has few.
    std::uint64_t walkerRays = 0, detectedRays = 0;
    /// Cells in which rays that met the walker ended, said occupied after the last scan,
    /// though the walker is not there any more.
    std::uint64_t ghosts = 0;
    /// Cells in which rays that met the box ended, said occupied when it was taken away.
    std::uint64_t boxCells = 0;
    /// Scans without the box until half of boxCells are not said occupied any more;
    /// nothing if that never happens.
    std::optional<std::uint64_t> scansToHalf;
    double detectedCellShare() const { return ratio(detected, walkerCells); }
    double detectedRayShare() const { return ratio(detectedRays, walkerRays); }

 private:
    static double ratio(std::uint64_t a, std::uint64_t b) {
        return b == 0 ? 0 : static_cast<double>(a) / static_cast<double>(b);
    }
};

/// Inserts all scans, and looks at the map after each.
/// \param resolution of the engine's map [m]
/// \param inserted scans of the world from the first on
/// \param exact the same rays with their end on the surface
/// \pre world.moves(); the engine's map is empty
MovingScore scoreMoving(const SimulatedWorld& world, double resolution,
                        const std::vector<PointScan>& inserted,
                        const std::vector<PointScan>& exact, BenchEngine& engine);

}  // namespace superray
