// SPDX-License-Identifier: BSD-3-Clause
// Kernels of all instruction sets: directions are those of the lines, counts and cells
// those of the plain walk.

#include <superray/core/traversal.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "core/directions/classified_scans.h"

namespace superray::test {
namespace {

template <typename T>
class WalkKernelsOf : public ::testing::Test {};
TYPED_TEST_SUITE(WalkKernelsOf, Dims);

TYPED_TEST(WalkKernelsOf, DirectionsAreThoseOfTheLines) {
    constexpr int Dim = TypeParam::value;
    constexpr int kLevels = 5;
    std::size_t unclassified = 0, certain = 0;
    const std::size_t rays = forEachScene<Dim>([&](const RayBundle<Dim>& scan) {
        const Cell<Dim> sensor = scan.geometry().cellOf(scan.commonOrigin());
        for (const WalkKernels<Dim>& kernels : allKernels<Dim>()) {
            const std::size_t first = 17;  // a part of the scan
            const ClassifiedScan<Dim> d = classify(scan, kLevels, kernels, first);
            for (std::size_t i = 0; i < scan.size() - first; ++i) {
                const Cell<Dim> end = scan.geometry().cellOf(scan.end(first + i));
                for (int a = 0; a < Dim; ++a)
                    ASSERT_EQ(d.endOffset[i][static_cast<unsigned>(a)],
                              std::abs(end[a] - sensor[a]));
                if (d.bins.binOf(d.subBin[i]) == d.bins.unclassified()) {
                    ++unclassified;
                    continue;
                }
                ++certain;
                ASSERT_EQ(d.lastSlice[i], d.endOffset[i][d.bins.sectorOf(d.subBin[i]) & 3]);
                const RayLine<Dim> line = lineOf(scan, first + i);
                std::uint32_t sector = static_cast<std::uint32_t>(line.major);
                for (int a = 0; a < Dim; ++a) sector |= line.flip[a] != 0 ? 4u << a : 0u;
                ASSERT_EQ(d.bins.sectorOf(d.subBin[i]), sector);
                std::uint32_t bin = d.bins.binOf(d.subBin[i]) - sector * d.bins.perSector();
                std::uint32_t subBin = d.subBin[i] % FirstUnsettled::kSubBins;
                ASSERT_LT(bin, 1u << (kLevels * (Dim - 1)));
                constexpr int kSubBinsPerAxis = DirectionBins<Dim>::kAxisSubBins << kLevels;
                for (int a = 0; a < Dim; ++a) {
                    if (a == line.major) continue;
                    const double at =
                        static_cast<double>(line.slope[a]) / kUnitsPerCell * kSubBinsPerAxis;
                    const std::uint32_t part =
                        (bin & ((1u << kLevels) - 1)) * DirectionBins<Dim>::kAxisSubBins +
                        subBin % DirectionBins<Dim>::kAxisSubBins;
                    const double margin = ClassifiedBatch<Dim>::kSlopeMargin * kSubBinsPerAxis;
                    ASSERT_GE(at, part - margin);
                    ASSERT_LE(at, part + 1 + margin);
                    bin >>= kLevels;
                    subBin /= DirectionBins<Dim>::kAxisSubBins;
                }
                ASSERT_EQ(subBin, 0u);
            }
        }
    });
    EXPECT_EQ(rays, kScans * kRays);
    EXPECT_GT(certain, rays / 2);
    EXPECT_GT(unclassified, 100u);
}

TYPED_TEST(WalkKernelsOf, KernelsGiveTheSameEndsCountsAndCells) {
    constexpr int Dim = TypeParam::value;
    std::size_t walked = 0, kernelsTried = 0;
    const std::size_t rays = forEachScene<Dim>([&](const RayBundle<Dim>& scan) {
        const CellGeometry<Dim>& g = scan.geometry();
        const ClassifiedScan<Dim> d = classify(scan, 3);
        const BlockBox<Dim> box{blockOf<Dim>(g.cellOf(scan.lowest())),
                                blockOf<Dim>(g.cellOf(scan.highest()))};
        for (const WalkKernels<Dim>& kernels : allKernels<Dim>()) {
            ++kernelsTried;
            ScanCounts<Dim> expected, got;
            expected.reset(box);
            got.reset(box);
            const ClassifiedScan<Dim> ends = classify(scan, 3, kernels);
            ASSERT_EQ(ends.subBin, d.subBin);
            // Every other ray with the kernel for a few slices, of any length here.
            std::array<RayLanes, DirectionBins<Dim>::kSectors> waiting, ending;
            const auto walk = [&](RayLanes& lanes, WalkRays<Dim> kernel) {
                if (lanes.count == 0) return;
                std::fill(lanes.ray + lanes.count, std::end(lanes.ray), lanes.ray[0]);
                kernel(got, scan, lanes);
                got.flush(1);
                lanes.count = 0;
            };
            for (std::size_t i = 0; i < scan.size(); ++i) {
                const Cell<Dim> end = g.cellOf(scan.end(i));
                ASSERT_EQ(ends.block[i], got.directory.indexOf(blockOf<Dim>(end)));
                ASSERT_EQ(ends.local[i], static_cast<unsigned>(indexInBlock<Dim>(end)));
                if (d.bins.binOf(d.subBin[i]) == d.bins.unclassified()) continue;
                const RayLine<Dim> line = lineOf(scan, i);
                const auto from =
                    static_cast<std::int32_t>(i % static_cast<std::size_t>(line.slices() + 1));
                expected.addresses.reserveMore(static_cast<std::size_t>(line.steps()));
                walkPortable(expected, line, from, line.slices());
                expected.flush(1);
                const bool few = from > 0 && i % 2 == 0;
                RayLanes& lanes = (few ? ending : waiting)[d.bins.sectorOf(d.subBin[i])];
                lanes.sector = d.bins.sectorOf(d.subBin[i]);
                lanes.ray[lanes.count] = static_cast<std::uint32_t>(i);
                lanes.from[lanes.count] = from;
                if (++lanes.count == 8) walk(lanes, few ? kernels.walkEnds : kernels.walkRays);
            }
            for (RayLanes& lanes : waiting) walk(lanes, kernels.walkRays);
            for (RayLanes& lanes : ending) walk(lanes, kernels.walkEnds);
            ASSERT_EQ(got.traversed, expected.traversed);
            walked += got.traversed;
            for (std::size_t b = 0; b < expected.batch.blockCount(); ++b) {
                const auto own = got.ownBatchBlock(expected.batch.key(b));
                ASSERT_TRUE(own);
                const std::uint8_t* const counts = expected.batch.misses(b);
                ASSERT_TRUE(
                    std::equal(counts, counts + kBlockCells<Dim>, got.batch.misses(*own)));
                for (std::uint32_t least : {1u, 5u, 255u}) {
                    const BlockMask<Dim> mask = kernels.atLeast(counts, least);
                    for (int i = 0; i < kBlockCells<Dim>; ++i)
                        ASSERT_EQ(mask.test(i), counts[i] >= least);
                }
            }
        }
    });
    EXPECT_EQ(rays, kScans * kRays);
    EXPECT_EQ(kernelsTried, kScans * allKernels<Dim>().size());
    EXPECT_GT(walked, 100000u);
}

TYPED_TEST(WalkKernelsOf, RunsAreRaysThatGoAndEndAlike) {
    constexpr int Dim = TypeParam::value;
    std::size_t runs = 0;
    const std::size_t rays = forEachScene<Dim>([&](const RayBundle<Dim>& plain) {
        // Each ray twice, once as a hit and once or more as another.
        RayBundle<Dim> scan(plain.geometry(), plain.commonOrigin());
        for (std::size_t i = 0; i < plain.size(); ++i)
            for (std::size_t n = 0; n < 2 + i % 3; ++n)
                scan.add(plain.end(i), n == 0 ? RayEnd::hit : RayEnd::noReturn);
        for (const WalkKernels<Dim>& kernels : allKernels<Dim>()) {
            const ClassifiedScan<Dim> d = classify(scan, 4, kernels);
            std::vector<std::uint32_t> expected;
            for (std::size_t i = 0; i < scan.size(); ++i) {
                const std::uint32_t bin = d.bins.binOf(d.subBin[i]);
                const bool same =
                    i % ClassifiedBatch<Dim>::kMost != 0 &&
                    bin == d.bins.binOf(d.subBin[i - 1]) && bin != d.bins.unclassified() &&
                    d.endOffset[i] == d.endOffset[i - 1] && scan.kind(i) == scan.kind(i - 1);
                if (!same) expected.push_back(static_cast<std::uint32_t>(i));
            }
            ASSERT_EQ(d.runs, expected);
            runs += expected.size();
            ASSERT_LT(expected.size(), scan.size());
        }
    });
    EXPECT_EQ(rays, kScans * kRays);
    EXPECT_GT(runs, rays);
}

TYPED_TEST(WalkKernelsOf, ChosenAreRaysWithSomethingToTell) {
    constexpr int Dim = TypeParam::value;
    constexpr int kBins = 501;
    Random random(4711);
    std::size_t chosen = 0, late = 0, besides = 0;
    for (std::size_t count : {0u, 1u, 15u, 16u, 17u, 9000u}) {
        std::vector<FirstUnsettled> unsettled(kBins);
        std::vector<std::uint16_t> last(count + 16);
        std::vector<std::uint32_t> subBin(count);  // chooseRays() reads no more
        const auto number = [&](int most) {
            return static_cast<std::uint32_t>(integer(random, 0, most));
        };
        for (FirstUnsettled& o : unsettled)
            o = number(2) == 0
                    ? FirstUnsettled::never()
                    : FirstUnsettled::of(static_cast<Slice>(number(40000)), number(0xFFFF));
        for (std::size_t i = 0; i < count; ++i) {
            subBin[i] = number(kBins * FirstUnsettled::kSubBins - 1);
            last[i] = static_cast<std::uint16_t>(number(40000));
        }
        std::vector<std::uint32_t> expected;
        for (std::uint32_t i = 0; i < count; ++i) {
            const FirstUnsettled first = unsettled[subBin[i] / 16];
            const bool marked = (first.subBins() >> subBin[i] % 16 & 1) != 0;
            const bool inTime = first.slice() <= last[i];
            if (marked && inTime) expected.push_back(i);
            late += marked && !inTime;
            besides += !marked && inTime;
        }
        for (const WalkKernels<Dim>& kernels : allKernels<Dim>()) {
            std::vector<std::uint32_t> got(count + 16);
            got.resize(kernels.chooseRays(subBin.data(), last.data(), count, unsettled.data(),
                                          got.data()));
            ASSERT_EQ(got, expected);
        }
        chosen += expected.size();
    }
    EXPECT_GT(chosen, 1000u);
    EXPECT_GT(late, 1000u);
    EXPECT_GT(besides, 1000u);
}

}  // namespace
}  // namespace superray::test
