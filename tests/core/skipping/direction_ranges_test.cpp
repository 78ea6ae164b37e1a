// SPDX-License-Identifier: BSD-3-Clause
// What empty-space skipping rests on: a boundary cell marks the sub-bins of all rays that pass
// it, and no ray can change the map before its first marked slice.

#include <superray/core/traversal.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "core/directions/classified_scans.h"
#include "skipping/settled_region.h"

namespace superray::test {
namespace {

template <typename T>
class DirectionRangesOf : public ::testing::Test {};
TYPED_TEST_SUITE(DirectionRangesOf, Dims);

TYPED_TEST(DirectionRangesOf, ABoundaryCellMarksTheSubBinsOfAllItsRays) {
    constexpr int Dim = TypeParam::value;
    Random random(31);
    std::size_t cells = 0, bins = 0, marked = 0;
    forEachScene<Dim>([&](const RayBundle<Dim>& scan) {
        for (int levels : {2, 6}) {
            const ClassifiedScan<Dim> d = classify(scan, levels);
            DirectionRanges<Dim> ranges = rangesOf(scan, d);
            for (std::size_t i = 0; i < scan.size(); i += 23) {
                const RayLine<Dim> line = lineOf(scan, i);
                if (d.bins.binOf(d.subBin[i]) == d.bins.unclassified() || line.steps() == 0)
                    continue;
                // One of its cells, and its slice.
                const auto wanted = static_cast<std::int64_t>(i * 7919) % line.steps();
                std::int64_t at = 0;
                Cell<Dim> boundary{};
                forEachFreeCell(line, [&](const Cell<Dim>& c) {
                    if (at++ == wanted) boundary = c;
                });
                const std::int32_t slice =
                    (boundary[line.major] ^ line.flip[line.major]) - line.first[line.major];
                // Alone, and with others, also in rows.
                BlockMask<Dim> mask;
                for (const bool others : {false, true}) {
                    for (int c = 0; others && c < kBlockCells<Dim>; ++c)
                        if (integer(random, 0, 3) > 0) mask.set(c);
                    mask.set(indexInBlock<Dim>(boundary));
                    {
                        typename DirectionRanges<Dim>::Marker marker(ranges);
                        ASSERT_TRUE(ranges.sees(blockOf<Dim>(boundary)));
                        marker.mark(blockOf<Dim>(boundary), mask);
                    }
                    ASSERT_LE(ranges.firstUnsettled(d.subBin[i]), slice) << i;
                    ++cells;
                    for (std::size_t j = 0; !others && j < scan.size(); j += 101) {
                        ++bins;
                        marked +=
                            ranges.firstUnsettled(d.subBin[j]) != DirectionRanges<Dim>::kNever;
                    }
                }
            }
        }
    });
    EXPECT_GT(cells, 2000u);
    // Ranges that are marked everywhere would pass the above.
    EXPECT_LT(marked, bins / 2);
}

// What is behind boundary cells is not looked at where all rays are walked from there on, but
// it is where some of a bin's sub-bins are not marked.
TEST(DirectionRanges, ATileThatIsOpenInSomeSubBinsHidesNothing) {
    constexpr int kLevels = 6, kPerAxis = 128, kLength = 100, kPlane = 60;
    const Point<3> origin = Point<3>::Constant(0.5);
    RayBundle<3> scan(CellGeometry<3>(1.0), origin);
    for (int i = 0; i < kPerAxis; ++i)
        for (int j = 0; j < kPerAxis; ++j) {
            const double a = (i + 0.3) / kPerAxis, b = (j + 0.6) / kPerAxis;
            scan.add(origin + kLength * Point<3>(a, b, 1));
            scan.add(origin + kLength * Point<3>(1, a, b));
        }
    ASSERT_EQ(scan.size(), 2u * kPerAxis * kPerAxis);
    const ClassifiedScan<3> d = classify(scan, kLevels);
    DirectionRanges<3> ranges = rangesOf(scan, d);
    std::optional<DirectionRanges<3>::Marker> marker(ranges);
    const BlockKey<3> behind{11, 3, 3};
    ASSERT_TRUE(ranges.sees(behind));
    // Every other column of a plane across the rays along z, all of one across those along x.
    BlockMask<3> columns, all;
    constexpr int kAt = kPlane % kBlockEdge;
    for (int i = 0; i < kBlockEdge; ++i)
        for (int j = 0; j < kBlockEdge; ++j) {
            if (i % 2 == 0) columns.set(indexInBlock<3>({i, j, kAt}));
            all.set(indexInBlock<3>({kAt, i, j}));
        }
    constexpr int kBlock = kPlane / kBlockEdge;
    for (int i = 0; i <= kBlock; ++i)
        for (int j = 0; j <= kBlock; ++j) marker->mark({i, j, kBlock}, columns);
    for (int i = 0; i <= kBlock; ++i)
        for (int j = 0; j <= kBlock; ++j) marker->mark({kBlock, i, j}, all);
    EXPECT_FALSE(ranges.sees(behind));  // so there were enough to take notice
    marker.reset();                     // completes the marks
    int free = 0;
    for (std::size_t i = 0; i < scan.size(); i += 2) {
        if (ranges.firstUnsettled(d.subBin[i]) != DirectionRanges<3>::kNever) continue;
        ++free;
        forEachFreeCell(lineOf(scan, i), [&](const Cell<3>& cell) {
            ASSERT_TRUE(ranges.sees(blockOf<3>(cell))) << i;
        });
        if (::testing::Test::HasFatalFailure()) return;
    }
    EXPECT_GT(free, 1000);
}

// Cells next to the sensor are seen in a good part of all directions, but not in all that
// pass their bounds on one axis here and on the other there.
TEST(DirectionRanges, ANearCellIsMarkedForFewRaysThatMissIt) {
    constexpr int kLevels = 6, kPerAxis = 160, kLength = 50, kNear = 3;
    const Point<3> origin(0.1, 0.35, 0.2);
    RayBundle<3> scan(CellGeometry<3>(1.0), origin);
    for (int i = 0; i < kPerAxis; ++i)
        for (int j = 0; j < kPerAxis; ++j)
            scan.add(origin +
                     kLength * Point<3>((i + 0.3) / kPerAxis, (j + 0.6) / kPerAxis, 1));
    const ClassifiedScan<3> d = classify(scan, kLevels);
    DirectionRanges<3> ranges = rangesOf(scan, d);
    int passing = 0, missing = 0;
    for (int cell = 0; cell < kNear * kNear * kNear; ++cell) {
        const Cell<3> near{cell % kNear, cell / kNear % kNear, cell / (kNear * kNear)};
        BlockMask<3> mask;
        mask.set(indexInBlock<3>(near));
        DirectionRanges<3>::Marker(ranges).mark(blockOf<3>(near), mask);
        for (std::size_t i = 0; i < scan.size(); i += 7) {
            bool passes = false;
            forEachFreeCell(lineOf(scan, i), 0, kNear,
                            [&](const Cell<3>& c) { passes |= c == near; });
            const bool marked =
                ranges.firstUnsettled(d.subBin[i]) != DirectionRanges<3>::kNever;
            ASSERT_LE(passes, marked) << i;
            passing += passes;
            missing += marked && !passes;
        }
    }
    EXPECT_GT(passing, 10000);
    EXPECT_LT(missing, passing / 10);
}

/// Walks two thirds of the rays, grows the settled region and checks what is skipped.
template <int Dim>
void checkNothingIsMissed(const RayBundle<Dim>& scan, std::uint64_t mostWork,
                          std::size_t& skipped, std::size_t& left) {
    const CellGeometry<Dim>& g = scan.geometry();
    ScanCounts<Dim> counts;
    const BlockBox<Dim> box{blockOf<Dim>(g.cellOf(scan.lowest())),
                            blockOf<Dim>(g.cellOf(scan.highest()))};
    counts.reset(box);
    for (std::size_t i = 0; i < scan.size(); ++i) {
        if (i % 3 == 0) continue;
        const RayLine<Dim> line = lineOf(scan, i);
        counts.addresses.reserveMore(static_cast<std::size_t>(line.steps()));
        walkPortable(counts, line, 0, line.slices());
        counts.flush(1);
    }
    const ClassifiedScan<Dim> d = classify(scan, 5);
    DirectionRanges<Dim> ranges = rangesOf(scan, d);
    SettledRegion<Dim> region;
    region.reset(box, nullptr, {SensorModel(), UpdatePolicy::oncePerScan, {}}, nullptr);
    region.grow(g.cellOf(scan.commonOrigin()), counts, ranges, mostWork);
    for (std::size_t i = 0; i < scan.size(); ++i) {
        const RayLine<Dim> line = lineOf(scan, i);
        const std::int32_t from =
            std::min<std::int32_t>(ranges.firstUnsettled(d.subBin[i]), line.slices());
        forEachFreeCell(line, 0, from, [&](const Cell<Dim>& c) {
            ++skipped;
            const auto block = counts.ownBatchBlock(blockOf<Dim>(c));
            ASSERT_TRUE(block);
            ASSERT_GE(counts.batch.misses(*block)[indexInBlock<Dim>(c)], 1u);
        });
        if (::testing::Test::HasFatalFailure()) return;
        left += static_cast<std::size_t>(line.slices() - from);
    }
}

TYPED_TEST(DirectionRangesOf, NothingThatMattersIsBeforeTheFirstMarkedSlice) {
    constexpr int Dim = TypeParam::value;
    std::size_t skipped = 0, left = 0, skippedEarly = 0, leftEarly = 0;
    const std::size_t rays = forEachScene<Dim>([&](const RayBundle<Dim>& scan) {
        checkNothingIsMissed<Dim>(scan, 1u << 30, skipped, left);
        if (::testing::Test::HasFatalFailure()) return;
        checkNothingIsMissed<Dim>(scan, 500, skippedEarly, leftEarly);
    });
    EXPECT_EQ(rays, kScans * kRays);
    EXPECT_GT(skipped, 100000u);
    // With little work allowed, the region ends earlier, and still is right.
    EXPECT_GT(skippedEarly, 1000u);
    EXPECT_GT(leftEarly, left);
}

}  // namespace
}  // namespace superray::test
