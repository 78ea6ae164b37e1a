// Kernels of all instruction sets: directions are those of the lines, counts and cells
// those of the plain walk.

#include <superray/core/traversal.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "core/directions/scan_directions.h"

namespace superray::test {
namespace {

template <typename T>
class WalkKernelsOf : public ::testing::Test {};
TYPED_TEST_SUITE(WalkKernelsOf, Dims);

TYPED_TEST(WalkKernelsOf, DirectionsAreThoseOfTheLines) {
    constexpr int Dim = TypeParam::value;
    constexpr int kLevels = 5;
    std::size_t lone = 0, certain = 0;
    const std::size_t rays = forEachScene<Dim>([&](const RayBundle<Dim>& scan) {
        const Cell<Dim> sensor = scan.geometry().cellOf(scan.commonOrigin());
        for (const WalkKernels<Dim>& kernels : allKernels<Dim>()) {
            const std::size_t first = 17;  // a part of the scan
            const ScanDirections<Dim> d = directionsOf(scan, kLevels, kernels, first);
            for (std::size_t i = 0; i < scan.size() - first; ++i) {
                const Cell<Dim> end = scan.geometry().cellOf(scan.end(first + i));
                for (int a = 0; a < Dim; ++a)
                    ASSERT_EQ(d.extent[i][static_cast<unsigned>(a)],
                              std::abs(end[a] - sensor[a]));
                if (d.tiles.tileOf(d.spot[i]) == d.tiles.lone()) {
                    ++lone;
                    continue;
                }
                ++certain;
                ASSERT_EQ(d.lastSlice[i], d.extent[i][d.tiles.kindOf(d.spot[i]) & 3]);
                const RayLine<Dim> line = lineOf(scan, first + i);
                std::uint32_t kind = static_cast<std::uint32_t>(line.dominant);
                for (int a = 0; a < Dim; ++a) kind |= line.flip[a] != 0 ? 4u << a : 0u;
                ASSERT_EQ(d.tiles.kindOf(d.spot[i]), kind);
                std::uint32_t tile = d.tiles.tileOf(d.spot[i]) - kind * d.tiles.perKind();
                std::uint32_t spot = d.spot[i] % Opening::kSpots;
                ASSERT_LT(tile, 1u << (kLevels * (Dim - 1)));
                constexpr int kSpotsPerAxis = DirectionTiles<Dim>::kAxisSpots << kLevels;
                for (int a = 0; a < Dim; ++a) {
                    if (a == line.dominant) continue;
                    const double at =
                        static_cast<double>(line.slope[a]) / kUnitsPerCell * kSpotsPerAxis;
                    const std::uint32_t number =
                        (tile & ((1u << kLevels) - 1)) * DirectionTiles<Dim>::kAxisSpots +
                        spot % DirectionTiles<Dim>::kAxisSpots;
                    const double margin = RayDirections<Dim>::kSlopeMargin * kSpotsPerAxis;
                    ASSERT_GE(at, number - margin);
                    ASSERT_LE(at, number + 1 + margin);
                    tile >>= kLevels;
                    spot /= DirectionTiles<Dim>::kAxisSpots;
                }
                ASSERT_EQ(spot, 0u);
            }
        }
    });
    EXPECT_EQ(rays, kScans * kRays);
    EXPECT_GT(certain, rays / 2);
    EXPECT_GT(lone, 100u);
}

TYPED_TEST(WalkKernelsOf, KernelsGiveTheSameEndsCountsAndCells) {
    constexpr int Dim = TypeParam::value;
    std::size_t walked = 0, kernelsTried = 0;
    const std::size_t rays = forEachScene<Dim>([&](const RayBundle<Dim>& scan) {
        const CellGeometry<Dim>& g = scan.geometry();
        const ScanDirections<Dim> d = directionsOf(scan, 3);
        const BlockBox<Dim> box{blockOf<Dim>(g.cellOf(scan.lowest())),
                                blockOf<Dim>(g.cellOf(scan.highest()))};
        for (const WalkKernels<Dim>& kernels : allKernels<Dim>()) {
            ++kernelsTried;
            WalkState<Dim> expected, got;
            expected.reset(box);
            got.reset(box);
            const ScanDirections<Dim> ends = directionsOf(scan, 3, kernels);
            ASSERT_EQ(ends.spot, d.spot);
            // Every other ray with the kernel for a few slices, of any length here.
            std::array<RayLanes, DirectionTiles<Dim>::kKinds> waiting, ending;
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
                if (d.tiles.tileOf(d.spot[i]) == d.tiles.lone()) continue;
                const RayLine<Dim> line = lineOf(scan, i);
                const auto from =
                    static_cast<std::int32_t>(i % static_cast<std::size_t>(line.slices() + 1));
                expected.addresses.reserveMore(static_cast<std::size_t>(line.steps()));
                walkPortable(expected, line, from, line.slices());
                expected.flush(1);
                const bool few = from > 0 && i % 2 == 0;
                RayLanes& lanes = (few ? ending : waiting)[d.tiles.kindOf(d.spot[i])];
                lanes.kind = d.tiles.kindOf(d.spot[i]);
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
                scan.add(plain.end(i), n == 0 ? RayEnd::hit : RayEnd::open);
        for (const WalkKernels<Dim>& kernels : allKernels<Dim>()) {
            const ScanDirections<Dim> d = directionsOf(scan, 4, kernels);
            std::vector<std::uint32_t> expected;
            for (std::size_t i = 0; i < scan.size(); ++i) {
                const std::uint32_t tile = d.tiles.tileOf(d.spot[i]);
                const bool same = i % RayDirections<Dim>::kMost != 0 &&
                                  tile == d.tiles.tileOf(d.spot[i - 1]) &&
                                  tile != d.tiles.lone() && d.extent[i] == d.extent[i - 1] &&
                                  scan.kind(i) == scan.kind(i - 1);
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
    constexpr int kTiles = 501;
    Random random(4711);
    std::size_t chosen = 0, late = 0, besides = 0;
    for (std::size_t count : {0u, 1u, 15u, 16u, 17u, 9000u}) {
        std::vector<Opening> openings(kTiles);
        std::vector<std::uint16_t> last(count + 16);
        std::vector<std::uint32_t> spot(count);  // chooseRays() reads no more
        const auto number = [&](int most) {
            return static_cast<std::uint32_t>(integer(random, 0, most));
        };
        for (Opening& o : openings)
            o = number(2) == 0 ? Opening::never()
                               : Opening::of(static_cast<Slice>(number(40000)), number(0xFFFF));
        for (std::size_t i = 0; i < count; ++i) {
            spot[i] = number(kTiles * Opening::kSpots - 1);
            last[i] = static_cast<std::uint16_t>(number(40000));
        }
        std::vector<std::uint32_t> expected;
        for (std::uint32_t i = 0; i < count; ++i) {
            const Opening opening = openings[spot[i] / 16];
            const bool open = (opening.spots() >> spot[i] % 16 & 1) != 0;
            const bool inTime = opening.slice() <= last[i];
            if (open && inTime) expected.push_back(i);
            late += open && !inTime;
            besides += !open && inTime;
        }
        for (const WalkKernels<Dim>& kernels : allKernels<Dim>()) {
            std::vector<std::uint32_t> got(count + 16);
            got.resize(kernels.chooseRays(spot.data(), last.data(), count, openings.data(),
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
