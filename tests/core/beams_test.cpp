// What beams rest on: rough directions are near enough, bounds hold every cell
// of every ray, and each instruction set looks ahead alike.

#include <superray/core/traversal.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "beam_finder.h"
#include "chunk_queue.h"
#include "core/ray_generators.h"
#include "walk_kernel.h"

namespace superray {
namespace {

using test::Random;

template <typename T>
class Beams : public ::testing::Test {};
using Dims = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Beams, Dims);

constexpr int kRays = 3000;

/// Calls check(rays) for a scan of every scene, and counts rays.
template <int Dim, typename Check>
std::size_t forEachScene(const Check& check) {
    std::size_t rays = 0;
    for (test::Scene scene : test::kScenes) {
        Random random(900 + static_cast<std::uint64_t>(scene));
        const auto scan = test::makeScan<Dim>(scene, random, CellGeometry<Dim>(0.1), kRays);
        rays += scan.size();
        check(scan);
    }
    return rays;
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

TYPED_TEST(Beams, DirectionsAreWithinTheirMargin) {
    constexpr int Dim = TypeParam::value;
    std::size_t lone = 0, certain = 0;
    const std::size_t rays = forEachScene<Dim>([&](const RayBundle<Dim>& scan) {
        for (const WalkKernels<Dim>& kernels : allKernels<Dim>()) {
            RayDirections<Dim> directions;
            directions.resize(scan.size());
            kernels.findDirections(scan, 0, scan.size(), directions);
            for (std::size_t i = 0; i < scan.size(); ++i) {
                if (directions.kind[i] == RayDirections<Dim>::kLone) {
                    ++lone;
                    continue;
                }
                ++certain;
                const RayLine<Dim> line(scan.geometry(), scan.origin(i), scan.end(i));
                std::uint32_t kind = static_cast<std::uint32_t>(line.dominant);
                for (int a = 0; a < Dim; ++a) kind |= line.flip[a] != 0 ? 4u << a : 0u;
                ASSERT_EQ(directions.kind[i], kind);
                for (int a = 0, m = 0; a < Dim; ++a) {
                    if (a == line.dominant) continue;
                    const double exact =
                        static_cast<double>(line.slope[a]) / double{kUnitsPerCell};
                    ASSERT_NEAR(directions.slope[m++][i], exact,
                                RayDirections<Dim>::kSlopeMargin);
                }
            }
        }
    });
    EXPECT_EQ(rays, std::size(test::kScenes) * kRays);
    EXPECT_GT(certain, rays / 2);
    EXPECT_GT(lone, 100u);
}

TYPED_TEST(Beams, BoundsHoldAllCellsAndEachRayIsInOneBeam) {
    constexpr int Dim = TypeParam::value;
    std::size_t beamsOfSeveral = 0;
    const std::size_t rays = forEachScene<Dim>([&](const RayBundle<Dim>& scan) {
        const Units<Dim> origin = RayLine<Dim>::unitsOf(scan.geometry(), scan.commonOrigin());
        for (std::size_t shares : {1u, 3u}) {
            BeamFinder<Dim> finder;
            finder.find(scan, shares);
            std::vector<int> seen(scan.size(), 0);
            for (std::size_t s = 0; s < shares; ++s) {
                for (const BeamRays<Dim>& some : finder.beams(s)) {
                    ASSERT_LT(some.begin, some.end);
                    for (std::size_t i = some.begin; i < some.end; ++i) ++seen[finder.ray(i)];
                    if (some.kind == RayDirections<Dim>::kLone) {
                        ASSERT_EQ(some.end, some.begin + 1);
                        continue;
                    }
                    beamsOfSeveral += some.end > some.begin + 1;
                    const Beam<Dim> beam(some, origin);
                    for (std::size_t i = some.begin; i < some.end; ++i) {
                        const RayLine<Dim> line(scan.geometry(), scan.commonOrigin(),
                                                scan.end(finder.ray(i)));
                        ASSERT_LE(line.slices(), beam.slices);
                        for (int a = 0; a < Dim; ++a) {
                            if (a == line.dominant) continue;
                            for (std::int32_t k = 0; k < line.slices(); ++k) {
                                ASSERT_GE(line.entryCell(a, k), beam.low(a, k));
                                ASSERT_LE(line.exitCell(a, k), beam.high(a, k));
                            }
                        }
                    }
                }
            }
            ASSERT_EQ(std::count(seen.begin(), seen.end(), 1),
                      static_cast<std::ptrdiff_t>(scan.size()));
        }
    });
    EXPECT_EQ(rays, std::size(test::kScenes) * kRays);
    EXPECT_GT(beamsOfSeveral, 1000u);
}

TYPED_TEST(Beams, NoKernelLooksPastACellThatMatters) {
    constexpr int Dim = TypeParam::value;
    std::size_t looks = 0, saturated = 0;
    forEachScene<Dim>([&](const RayBundle<Dim>& scan) {
        const CellGeometry<Dim>& g = scan.geometry();
        BeamFinder<Dim> finder;
        finder.find(scan, 1);
        const Units<Dim> origin = RayLine<Dim>::unitsOf(g, scan.commonOrigin());
        const BlockBox<Dim> box{blockOf<Dim>(g.cellOf(scan.lowest())),
                                blockOf<Dim>(g.cellOf(scan.highest()))};
        std::vector<std::int32_t> expected;  // per beam
        for (const WalkKernels<Dim>& kernels : allKernels<Dim>()) {
            WalkState<Dim> state;
            state.reset(box);
            state.countMapSaturation(nullptr, SensorModel(), UpdatePolicy::oncePerScan);
            // Two thirds of the rays are walked; then there is much to look past.
            for (std::size_t i = 0; i < scan.size(); ++i) {
                if (i % 3 == 0) continue;
                const RayLine<Dim> line(g, scan.commonOrigin(), scan.end(i));
                state.addresses.reserveMore(static_cast<std::size_t>(line.steps()));
                walkPortable(state, line, 0, line.slices());
                state.flush(1);
            }
            std::size_t at = 0;
            for (const BeamRays<Dim>& rays : finder.beams(0)) {
                if (rays.kind == RayDirections<Dim>::kLone) continue;
                const Beam<Dim> beam(rays, origin);
                const std::int32_t slice =
                    kernels.firstUnsaturated(state, beam, 0, beam.slices);
                ASSERT_GE(slice, 0);
                ASSERT_LE(slice, beam.slices);
                if (expected.size() == at) expected.push_back(slice);  // the portable one
                // Vector versions give up on wide beams, so they may stop earlier.
                ASSERT_LE(slice, expected[at]);
                bool wide = false;
                for (std::int32_t k = 0; k < expected[at]; ++k)
                    for (int a = 0; a < Dim; ++a)
                        wide |= a != beam.dominant && beam.high(a, k) - beam.low(a, k) > 3;
                if (!wide) {
                    ASSERT_EQ(slice, expected[at]);
                }
                ++at;
                ++looks;
                saturated += slice > 0;
            }
        }
    });
    EXPECT_GT(looks, 1000u);
    EXPECT_GT(saturated, looks / 4);
}

TEST(ChunkQueue, GivesEachChunkOnce) {
    for (std::size_t chunks : {0u, 1u, 7u, 1000u}) {
        constexpr std::size_t kThreads = 3;
        ChunkQueue queue(chunks, kThreads);
        std::vector<std::atomic<int>> taken(chunks);
        std::vector<std::thread> threads;
        for (std::size_t s = 0; s < kThreads; ++s)
            threads.emplace_back([&, s] {
                while (const auto c = queue.take(s)) ++taken.at(*c);
            });
        for (std::thread& t : threads) t.join();
        for (const auto& n : taken) EXPECT_EQ(n, 1);
        EXPECT_FALSE(queue.take(0));
    }
}

TEST(ChunkQueue, HelpsFromTheOtherEnd) {
    ChunkQueue queue(6, 2);
    EXPECT_EQ(queue.take(0), 0u);
    EXPECT_EQ(queue.take(1), 3u);
    EXPECT_EQ(queue.take(0), 1u);
    EXPECT_EQ(queue.take(0), 2u);
    EXPECT_EQ(queue.take(0), 5u);
    EXPECT_EQ(queue.take(1), 4u);
    EXPECT_EQ(queue.take(1), std::nullopt);
}

}  // namespace
}  // namespace superray
