// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/scan_integrator.h>
#include <superray/core/traversal.h>
#include <superray/eval/progress_meter.h>
#include <superray/eval/scan_character.h>

#include <cmath>
#include <sstream>
#include <unordered_map>
#include <unordered_set>

#include "text/text_table.h"

namespace superray {

ScanCharacter characterOf(const std::vector<PointScan>& scans, double resolution) {
    const CellGeometry<3> geometry(resolution);
    std::unordered_set<BlockKey<3>, IndexHash> blocks;
    ScanCharacter sum;
    for (const PointScan& scan : scans) {
        std::unordered_map<BlockKey<3>, BlockMask<3>, IndexHash> free, ends;
        RayBundle<3> rays(geometry, scan.origin.cast<double>());
        for (const Eigen::Vector3f& p : scan.points) {
            rays.add(p.cast<double>());
            const double range = (p - scan.origin).cast<double>().norm();
            sum.meanRange += range;
            sum.largestRange = std::max(sum.largestRange, range);
        }
        for (std::size_t i = 0; i < rays.size(); ++i) {
            BlockMask<3>* mask = nullptr;
            BlockKey<3> key{};
            forEachFreeCell(RayLine<3>(geometry, rays.origin(i), rays.end(i)),
                            [&](const Cell<3>& cell) {
                                const auto block = blockOf<3>(cell);
                                if (mask == nullptr || block != key) mask = &free[key = block];
                                mask->set(indexInBlock<3>(cell));
                                ++sum.rayCells;
                            });
            const Cell<3> end = geometry.cellOf(rays.end(i));
            ends[blockOf<3>(end)].set(indexInBlock<3>(end));
        }
        const auto count = [&](const auto& masks, double& cells) {
            for (const auto& [key, mask] : masks) {
                cells += mask.count();
                blocks.insert(key);
            }
        };
        count(free, sum.distinctCells);
        count(ends, sum.endCells);
        sum.points += static_cast<double>(scan.points.size());
    }
    if (scans.empty()) return sum;
    sum.meanRange /= sum.points;
    sum.scans = scans.size();
    sum.blocks = blocks.size();
    const auto n = static_cast<double>(scans.size());
    for (double* total : {&sum.points, &sum.rayCells, &sum.distinctCells, &sum.endCells})
        *total /= n;
    return sum;
}

std::string describe(const ScanCharacter& c) {
    const auto count = [](double value) {
        return formatCount(static_cast<std::uint64_t>(std::llround(value)));
    };
    std::ostringstream out;
    out << "scans           " << c.scans << " of " << count(c.points) << " points\n"
        << "ranges          " << formatShort(c.meanRange) << " m on average, at most "
        << formatShort(c.largestRange) << " m\n"
        << "cells of rays   " << count(c.rayCells) << " a scan, " << count(c.distinctCells)
        << " different ones (" << formatShort(c.rayCells / std::max(1.0, c.distinctCells))
        << " visits each)\n"
        << "end cells       " << count(c.endCells) << " a scan\n"
        << "blocks of 8x8x8 " << formatCount(c.blocks) << " in all scans\n";
    return out.str();
}

}  // namespace superray
