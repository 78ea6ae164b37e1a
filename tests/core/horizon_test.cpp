// What walks from the horizon rest on: directions are those of the lines, no tile
// misses an open cell, and nothing that matters is before the horizon.

#include <superray/core/traversal.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <numeric>

#include "core/ray_generators.h"
#include "ray_sample.h"
#include "settled_region.h"
#include "walk_kernel.h"

namespace superray {
namespace {

using test::Random;

template <typename T>
class HorizonOf : public ::testing::Test {};
using Dims = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(HorizonOf, Dims);

constexpr int kRays = 3000;
constexpr std::size_t kScans = 2 * std::size(test::kScenes);

/// Calls check(rays) for a scan of every scene, in double and in single precision, and
/// counts rays.
template <int Dim, typename Check>
std::size_t forEachScene(const Check& check) {
    std::size_t count = 0, singles = 0;
    for (test::Scene scene : test::kScenes) {
        Random random(900 + static_cast<std::uint64_t>(scene));
        const auto scan = test::makeScan<Dim>(scene, random, CellGeometry<Dim>(0.1), kRays);
        for (const RayBundle<Dim>& rays : {scan, test::rounded(scan)}) {
            count += rays.size();
            singles += rays.singlePrecision();
            check(rays);
            if (::testing::Test::HasFatalFailure()) return 0;
        }
    }
    EXPECT_EQ(singles, kScans / 2);
    return count;
}

template <int Dim>
std::vector<WalkKernels<Dim>> allKernels() {
    std::vector<WalkKernels<Dim>> kernels{portableKernels<Dim>()};
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) kernels.push_back(avx2Kernels<Dim>());
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512dq"))
        kernels.push_back(avx512Kernels<Dim>());
#endif
    return kernels;
}

template <int Dim>
RayLine<Dim> lineOf(const RayBundle<Dim>& scan, std::size_t ray) {
    return RayLine<Dim>(scan.geometry(), scan.commonOrigin(), scan.end(ray));
}

/// RayDirections of all rays from `first` on.
template <int Dim>
struct ScanDirections {
    DirectionTiles<Dim> tiles;
    std::vector<std::uint32_t> spot;
    std::vector<std::uint16_t> lastSlice;
    std::vector<Extent> extent;
    std::vector<std::uint32_t> block;
    std::vector<std::uint16_t> local;
    std::vector<std::uint32_t> runs;  ///< where they begin
    std::uint32_t kinds = 0;
};

/// Calls use(first ray, number of rays, directions) for pieces of a scan.
template <int Dim, typename Use>
void inPieces(const WalkKernels<Dim>& kernels, const RayBundle<Dim>& scan, std::size_t first,
              ScanDirections<Dim>& all, const Use& use) {
    const BlockBox<Dim> box{blockOf<Dim>(scan.geometry().cellOf(scan.lowest())),
                            blockOf<Dim>(scan.geometry().cellOf(scan.highest()))};
    BlockDirectory<Dim> directory;
    directory.reset(box);
    constexpr std::size_t kSlack = RayDirections<Dim>::kSlack;
    all.spot.resize(scan.size() - first + kSlack);
    all.lastSlice.resize(scan.size() - first + kSlack);
    const auto piece = std::make_unique<RayDirections<Dim>>();
    for (std::size_t at = first; at < scan.size(); at += RayDirections<Dim>::kMost) {
        const std::size_t count = std::min(RayDirections<Dim>::kMost, scan.size() - at);
        kernels.findDirections(scan, at, count, directory, all.tiles,
                               all.spot.data() + (at - first),
                               all.lastSlice.data() + (at - first), *piece);
        use(at, count, *piece);
    }
}

template <int Dim>
ScanDirections<Dim> directionsOf(const RayBundle<Dim>& scan, int levels,
                                 const WalkKernels<Dim>& kernels = bestKernels<Dim>(),
                                 std::size_t first = 0) {
    ScanDirections<Dim> all;
    all.tiles.levels = levels;
    inPieces(kernels, scan, first, all,
             [&](std::size_t at, std::size_t count, const RayDirections<Dim>& d) {
                 const auto n = static_cast<std::ptrdiff_t>(count);
                 all.extent.insert(all.extent.end(), d.extent.begin(), d.extent.begin() + n);
                 all.block.insert(all.block.end(), d.block.begin(), d.block.begin() + n);
                 all.local.insert(all.local.end(), d.local.begin(), d.local.begin() + n);
                 all.kinds |= d.kinds;
                 std::vector<std::uint32_t> starts(count + 16);
                 const std::size_t runs =
                     kernels.findRuns(d, scan.kinds() + at, count, starts.data());
                 for (std::size_t i = 0; i < runs; ++i)
                     all.runs.push_back(static_cast<std::uint32_t>(at - first) + starts[i]);
             });
    all.spot.resize(scan.size() - first);  // vector loads are over
    return all;
}

template <int Dim>
Horizon<Dim> horizonOf(const RayBundle<Dim>& scan, ScanDirections<Dim> directions) {
    Horizon<Dim> horizon;
    horizon.reset(directions.tiles,
                  RayLine<Dim>::unitsOf(scan.geometry(), scan.commonOrigin()));
    inPieces(bestKernels<Dim>(), scan, 0, directions,
             [&](std::size_t, std::size_t count, const RayDirections<Dim>& d) {
                 std::vector<std::uint32_t> rays(count);
                 std::iota(rays.begin(), rays.end(), 0);
                 horizon.addRays(d, rays.data(), count);
             });
    horizon.completeReach();
    return horizon;
}

TYPED_TEST(HorizonOf, DirectionsAreThoseOfTheLines) {
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

TYPED_TEST(HorizonOf, AnOpenCellIsNotedInTheSpotsOfAllItsRays) {
    constexpr int Dim = TypeParam::value;
    Random random(31);
    std::size_t cells = 0, tiles = 0, noted = 0;
    forEachScene<Dim>([&](const RayBundle<Dim>& scan) {
        for (int levels : {2, 6}) {
            const ScanDirections<Dim> d = directionsOf(scan, levels);
            Horizon<Dim> horizon = horizonOf(scan, d);
            for (std::size_t i = 0; i < scan.size(); i += 23) {
                const RayLine<Dim> line = lineOf(scan, i);
                if (d.tiles.tileOf(d.spot[i]) == d.tiles.lone() || line.steps() == 0) continue;
                // One of its cells, and its slice.
                const auto wanted = static_cast<std::int64_t>(i * 7919) % line.steps();
                std::int64_t at = 0;
                Cell<Dim> open{};
                forEachFreeCell(line, [&](const Cell<Dim>& c) {
                    if (at++ == wanted) open = c;
                });
                const std::int32_t slice = (open[line.dominant] ^ line.flip[line.dominant]) -
                                           line.first[line.dominant];
                // Alone, and with others, also in rows.
                BlockMask<Dim> mask;
                for (const bool others : {false, true}) {
                    for (int c = 0; others && c < kBlockCells<Dim>; ++c)
                        if (test::integer(random, 0, 3) > 0) mask.set(c);
                    mask.set(indexInBlock<Dim>(open));
                    horizon.clear();
                    ASSERT_TRUE(horizon.reaches(blockOf<Dim>(open)));
                    horizon.open(blockOf<Dim>(open), mask);
                    horizon.completeOpen();
                    ASSERT_LE(horizon.firstOpen(d.spot[i]), slice) << i;
                    ++cells;
                    for (std::size_t j = 0; !others && j < scan.size(); j += 101) {
                        ++tiles;
                        noted += horizon.firstOpen(d.spot[j]) != Horizon<Dim>::kNever;
                    }
                }
            }
        }
    });
    EXPECT_GT(cells, 2000u);
    // A horizon that is open everywhere would pass the above.
    EXPECT_LT(noted, tiles / 2);
}

// What is behind open cells is not looked at where all rays are walked from there on, but
// it is where some of a tile's spots are not open.
TEST(Horizon, ATileThatIsOpenInSomeSpotsHidesNothing) {
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
    const ScanDirections<3> d = directionsOf(scan, kLevels);
    Horizon<3> horizon = horizonOf(scan, d);
    horizon.clear();
    const BlockKey<3> behind{11, 3, 3};
    ASSERT_TRUE(horizon.reaches(behind));
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
        for (int j = 0; j <= kBlock; ++j) horizon.open({i, j, kBlock}, columns);
    for (int i = 0; i <= kBlock; ++i)
        for (int j = 0; j <= kBlock; ++j) horizon.open({kBlock, i, j}, all);
    EXPECT_FALSE(horizon.reaches(behind));  // so there were enough to take notice
    horizon.completeOpen();
    int free = 0;
    for (std::size_t i = 0; i < scan.size(); i += 2) {
        if (horizon.firstOpen(d.spot[i]) != Horizon<3>::kNever) continue;
        ++free;
        forEachFreeCell(lineOf(scan, i), [&](const Cell<3>& cell) {
            ASSERT_TRUE(horizon.reaches(blockOf<3>(cell))) << i;
        });
        if (::testing::Test::HasFatalFailure()) return;
    }
    EXPECT_GT(free, 1000);
}

// Cells next to the sensor are seen in a good part of all directions, but not in all that
// pass their bounds on one axis here and on the other there.
TEST(Horizon, ANearCellIsNotedForFewRaysThatMissIt) {
    constexpr int kLevels = 6, kPerAxis = 160, kLength = 50, kNear = 3;
    const Point<3> origin(0.1, 0.35, 0.2);
    RayBundle<3> scan(CellGeometry<3>(1.0), origin);
    for (int i = 0; i < kPerAxis; ++i)
        for (int j = 0; j < kPerAxis; ++j)
            scan.add(origin +
                     kLength * Point<3>((i + 0.3) / kPerAxis, (j + 0.6) / kPerAxis, 1));
    const ScanDirections<3> d = directionsOf(scan, kLevels);
    Horizon<3> horizon = horizonOf(scan, d);
    int passing = 0, missing = 0;
    for (int cell = 0; cell < kNear * kNear * kNear; ++cell) {
        const Cell<3> near{cell % kNear, cell / kNear % kNear, cell / (kNear * kNear)};
        BlockMask<3> mask;
        mask.set(indexInBlock<3>(near));
        horizon.clear();
        horizon.open(blockOf<3>(near), mask);
        horizon.completeOpen();
        for (std::size_t i = 0; i < scan.size(); i += 7) {
            bool passes = false;
            forEachFreeCell(lineOf(scan, i), 0, kNear,
                            [&](const Cell<3>& c) { passes |= c == near; });
            const bool noted = horizon.firstOpen(d.spot[i]) != Horizon<3>::kNever;
            ASSERT_LE(passes, noted) << i;
            passing += passes;
            missing += noted && !passes;
        }
    }
    EXPECT_GT(passing, 10000);
    EXPECT_LT(missing, passing / 10);
}

/// Walks two thirds of the rays, looks around and checks what is skipped.
template <int Dim>
void checkNothingIsMissed(const RayBundle<Dim>& scan, std::uint64_t mostWork,
                          std::size_t& skipped, std::size_t& left) {
    const CellGeometry<Dim>& g = scan.geometry();
    WalkState<Dim> state;
    const BlockBox<Dim> box{blockOf<Dim>(g.cellOf(scan.lowest())),
                            blockOf<Dim>(g.cellOf(scan.highest()))};
    state.reset(box);
    for (std::size_t i = 0; i < scan.size(); ++i) {
        if (i % 3 == 0) continue;
        const RayLine<Dim> line = lineOf(scan, i);
        state.addresses.reserveMore(static_cast<std::size_t>(line.steps()));
        walkPortable(state, line, 0, line.slices());
        state.flush(1);
    }
    const ScanDirections<Dim> d = directionsOf(scan, 5);
    Horizon<Dim> horizon = horizonOf(scan, d);
    SettledRegion<Dim> region;
    region.reset(box, nullptr, SensorModel(), UpdatePolicy::oncePerScan);
    region.build(g.cellOf(scan.commonOrigin()), state, horizon, mostWork);
    for (std::size_t i = 0; i < scan.size(); ++i) {
        const RayLine<Dim> line = lineOf(scan, i);
        const std::int32_t from =
            std::min<std::int32_t>(horizon.firstOpen(d.spot[i]), line.slices());
        forEachFreeCell(line, 0, from, [&](const Cell<Dim>& c) {
            ++skipped;
            const auto block = state.ownBatchBlock(blockOf<Dim>(c));
            ASSERT_TRUE(block);
            ASSERT_GE(state.batch.misses(*block)[indexInBlock<Dim>(c)], 1u);
        });
        if (::testing::Test::HasFatalFailure()) return;
        left += static_cast<std::size_t>(line.slices() - from);
    }
}

TYPED_TEST(HorizonOf, NothingThatMattersIsBeforeTheHorizon) {
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

TYPED_TEST(HorizonOf, KernelsGiveTheSameEndsCountsAndCells) {
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

TYPED_TEST(HorizonOf, RunsAreRaysThatGoAndEndAlike) {
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

TYPED_TEST(HorizonOf, ChosenAreRaysWithSomethingToTell) {
    constexpr int Dim = TypeParam::value;
    constexpr int kTiles = 501;
    Random random(4711);
    std::size_t chosen = 0, late = 0, besides = 0;
    for (std::size_t count : {0u, 1u, 15u, 16u, 17u, 9000u}) {
        std::vector<Opening> openings(kTiles);
        std::vector<std::uint16_t> last(count + 16);
        std::vector<std::uint32_t> spot(count);  // chooseRays() reads no more
        const auto number = [&](int most) {
            return static_cast<std::uint32_t>(test::integer(random, 0, most));
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

TEST(RaySample, IsSpreadAndDependsOnTheNumberOfRaysOnly) {
    RaySample used;
    for (const std::size_t count : {0u, 5000u, 37u, 1u, 100000u, 640u}) {
        RaySample fresh;
        const std::vector<std::uint32_t> sample = used.of(count);
        ASSERT_EQ(sample, fresh.of(count)) << count;
        ASSERT_EQ(std::adjacent_find(sample.begin(), sample.end(), std::greater_equal<>{}),
                  sample.end());
        for (const std::uint32_t ray : sample) ASSERT_LT(ray, count);
        const double expected = RaySample::kShare * static_cast<double>(count);
        EXPECT_NEAR(static_cast<double>(sample.size()), expected, 2) << count;
    }
    // No column of a depth image is sampled much more than others.
    constexpr std::uint32_t kColumns = 640, kRows = 480;
    std::vector<int> perColumn(kColumns);
    for (const std::uint32_t ray : used.of(kColumns * kRows)) ++perColumn[ray % kColumns];
    const double mean = RaySample::kShare * kRows;
    for (const int n : perColumn) {
        EXPECT_GT(n, 0.5 * mean);
        EXPECT_LT(n, 1.5 * mean);
    }
}

TEST(Extent, ComparesAndJoinsAxisByAxis) {
    Random random(77);
    int within = 0;
    for (int i = 0; i < 2000; ++i) {
        std::int32_t a[3], b[3];
        Extent ea{}, eb{};
        bool expected = true;
        for (int axis = 0; axis < 3; ++axis) {
            const int most = test::integer(random, 0, 1) ? 65535 : 3;
            a[axis] = test::integer(random, 0, most);
            b[axis] = test::integer(random, 0, most);
            ea.set(axis, a[axis]);
            eb.set(axis, b[axis]);
            expected &= a[axis] <= b[axis];
        }
        ASSERT_EQ(ea.within(eb), expected);
        within += expected;
        for (unsigned axis = 0; axis < 3; ++axis) {
            ASSERT_EQ(ea[axis], a[axis]);
            ASSERT_EQ(ea.joined(eb)[axis], std::max(a[axis], b[axis]));
        }
    }
    EXPECT_GT(within, 200);
    EXPECT_LT(within, 1000);
}

}  // namespace
}  // namespace superray
