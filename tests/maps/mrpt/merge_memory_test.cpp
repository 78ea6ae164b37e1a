// SPDX-License-Identifier: BSD-3-Clause
// Merges into finer cells: refused before they have taken more memory than they may.

#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/storage/memory_limit_error.h>
#include <sys/resource.h>

#include <cstdlib>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

/// The most memory that this process has held so far [MB].
long peakMegabytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss / 1024;
}

template <class Map>
Map coarseMap() {
    Map map(0.1);
    auto scan = test::planarScan();
    scan->resizeScanAndAssign(90, 3.0f, true);
    map.insertObservation(*scan, CPose3D());
    return map;
}

template <class Map>
void setBound(Map& map, std::uint32_t megabytes) {
    TMapOptions options = map.options();
    options.creation.max_memory_megabytes = megabytes;
    map.setOptions(options);
}

// 500 cells become 30 million, in 90 MB of blocks.
constexpr double kFine = 0.004;
constexpr long kAllowedMegabytes = 40;

TEST(MergeMemory, ABoundRefusesAMergeBeforeItsBlocksAreMade) {
    const auto coarse = coarseMap<CSuperRayGridMap3D>();
    CSuperRayGridMap3D fine(kFine);
    setBound(fine, 2);
    const auto digest = fine.digest();
    const long before = peakMegabytes();
    const std::string message =
        test::messageOf([&] { fine.merge(coarse, CPose3D(0.01, 0, 0, 0.1, 0, 0)); });
    EXPECT_CONTAINS(message, "this merge");
    EXPECT_CONTAINS(message, "max_memory_megabytes = 2");
    EXPECT_LT(peakMegabytes() - before, kAllowedMegabytes);
    EXPECT_EQ(fine.digest(), digest);
    EXPECT_TRUE(fine.isEmpty());
}

TEST(MergeMemory, WithoutABoundTheMachinesLimitCounts) {
    const auto coarse = coarseMap<CSuperRayOctoMap>();
    CSuperRayOctoMap fine(kFine);
    const long before = peakMegabytes();
    ::setenv("SUPERRAY_MAP_MEGABYTES", "4", 1);
    const std::string message = test::messageOf([&] { fine.merge(coarse, CPose3D()); });
    ::unsetenv("SUPERRAY_MAP_MEGABYTES");
    EXPECT_CONTAINS(message, "this merge would take ");
    EXPECT_CONTAINS(message, "the limit is 4194304 (SUPERRAY_MAP_MEGABYTES)");
    EXPECT_LT(peakMegabytes() - before, kAllowedMegabytes);
    EXPECT_TRUE(fine.isEmpty());
}

TEST(MergeMemory, WhatFitsIsMergedCellByCell) {
    const auto coarse = coarseMap<CSuperRayGridMap2D>();
    CSuperRayGridMap2D fine(0.02);
    setBound(fine, 2);
    fine.merge(coarse, CPose3D());
    EXPECT_EQ(fine.cellTotals().known, 25 * coarse.cellTotals().known);
    EXPECT_EQ(fine.cellTotals().occupied, 25 * coarse.cellTotals().occupied);
    coarse.storage().forEachBlock([&](const BlockView<2>& block) {
        for (int i = 0; i < kBlockCells<2>; ++i) {
            if (!block.known.test(i)) continue;
            const Point<2> center =
                coarse.storage().geometry().center(cellInBlock<2>(block.key, i));
            const auto value = fine.storage().logOdds(fine.storage().geometry().cellOf(center));
            ASSERT_TRUE(value);
            EXPECT_EQ(*value, block.values[i]);
        }
    });
}

}  // namespace
}  // namespace superray
