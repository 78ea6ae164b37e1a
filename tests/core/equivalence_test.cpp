// SPDX-License-Identifier: BSD-3-Clause
// Every method, policy and number of threads against the reference mapper, bit
// for bit, over scans that follow each other into the same map.

#include "core/dims.h"
#include "core/ray_generators.h"
#include "core/test_map.h"

namespace superray {
namespace {

using namespace test;

template <typename T>
class Equivalence : public ::testing::Test {};
TYPED_TEST_SUITE(Equivalence, test::Dims);

TYPED_TEST(Equivalence, AllMethodsGiveTheReferenceMap) {
    constexpr int Dim = TypeParam::value;
    const CellGeometry<Dim> g(0.1);
    constexpr int kScans = 8, kRays = 900;
    std::uint64_t rays = 0, culled = 0, cut = 0, merged = 0;
    for (UpdatePolicy policy : kUpdatePolicies) {
        const SensorModel model = defaultModel(policy);
        for (test::Scene scene : test::kScenes) {
            Random random(50 + static_cast<std::uint64_t>(scene));
            std::vector<RayBundle<Dim>> scans;
            int singles = 0;
            for (int s = 0; s < kScans; ++s) {
                const auto scan = test::makeScan<Dim>(scene, random, g, kRays);
                scans.push_back(s % 2 == 0 ? scan : test::rounded(scan));
                singles += scans.back().singlePrecision();
            }
            ASSERT_EQ(singles, kScans / 2);
            ReferenceMapper<Dim> reference(model, policy);
            for (const auto& scan : scans) {
                reference.insert(scan);
                rays += scan.size();
            }
            for (Method method : kFastMethods) {
                for (unsigned threads : {1u, 2u, 3u}) {
                    SCOPED_TRACE(std::string(toString(method)) + " " + toString(policy));
                    IntegratorOptions options;
                    options.method = method;
                    options.policy = policy;
                    options.threads = threads;
                    ScanIntegrator<Dim> integrator;
                    TestMap<Dim> map;
                    for (const auto& scan : scans) {
                        map.apply(integrator.integrate(scan, model, options, &map), model,
                                  policy);
                        const ScanStatistics& s = integrator.statistics();
                        ASSERT_EQ(s.rays, scan.size());
                        if (method == Method::culling) culled += s.raysCulled;
                        if (method == Method::automatic) cut += s.raysCulled;
                        if (method == Method::superRays) merged += s.rays - s.superRays;
                    }
                    expectSameBits<Dim>(map.cells, reference.cells());
                    if (::testing::Test::HasFatalFailure()) return;
                }
            }
        }
    }
    EXPECT_GE(rays, 100000u);
    EXPECT_EQ(rays, 3u * 7 * kScans * kRays);
    EXPECT_GT(culled, 10000u);
    EXPECT_GT(cut, 50000u);  // of 3 * rays
    EXPECT_GT(merged, 1000u);
}

TYPED_TEST(Equivalence, OriginsPerRay) {
    constexpr int Dim = TypeParam::value;
    const CellGeometry<Dim> g(0.1);
    const SensorModel model;
    Random random(70);
    ReferenceMapper<Dim> reference(model);
    std::vector<TestMap<Dim>> maps(std::size(kFastMethods));
    std::uint64_t rays = 0;
    for (int s = 0; s < 12; ++s) {
        RayBundle<Dim> scan(g, Point<Dim>::Constant(0.05));
        for (int i = 0; i < 800; ++i)
            scan.add(Point<Dim>::Constant(0.05) + test::uniformPoint<Dim>(random, 0.06),
                     test::uniformPoint<Dim>(random, 2), RayEnd::hit);
        rays += scan.size();
        reference.insert(scan);
        for (std::size_t m = 0; m < maps.size(); ++m) {
            IntegratorOptions options;
            options.method = kFastMethods[m];
            options.threads = 1 + static_cast<unsigned>(s % 2);
            ScanIntegrator<Dim> integrator;
            maps[m].apply(integrator.integrate(scan, model, options, &maps[m]), model,
                          UpdatePolicy::everyRay);
        }
    }
    EXPECT_EQ(rays, 12u * 800);
    for (const TestMap<Dim>& map : maps) expectSameBits<Dim>(map.cells, reference.cells());
}

/// The map that some scans make with `auto`.
template <int Dim>
TestMap<Dim> mapOf(const std::vector<RayBundle<Dim>>& scans, UpdatePolicy policy,
                   unsigned threads) {
    const SensorModel model = defaultModel(policy);
    IntegratorOptions options;
    options.policy = policy;
    options.threads = threads;
    ScanIntegrator<Dim> integrator;
    TestMap<Dim> map;
    for (const auto& scan : scans)
        map.apply(integrator.integrate(scan, model, options, &map), model, policy);
    return map;
}

// Threads share out long rays by direction.
TYPED_TEST(Equivalence, LongRaysInThreads) {
    constexpr int Dim = TypeParam::value;
    const CellGeometry<Dim> g(0.1);
    Random random(80);
    std::vector<RayBundle<Dim>> scans;
    std::uint64_t rays = 0;
    for (int s = 0; s < 3; ++s) {
        RayBundle<Dim> scan(g, test::uniformPoint<Dim>(random, 0.5));
        for (int i = 0; i < 600; ++i) {
            Point<Dim> end = test::uniformPoint<Dim>(random, 15);
            if (i % 50 == 0) end[i % Dim] = scan.commonOrigin()[i % Dim];  // kind uncertain
            scan.add(end, i % 17 == 0 ? RayEnd::noReturn : RayEnd::hit);
        }
        rays += scan.size();
        scans.push_back(std::move(scan));
    }
    EXPECT_EQ(rays, 3u * 600);
    for (const UpdatePolicy policy : kUpdatePolicies) {
        ReferenceMapper<Dim> reference(defaultModel(policy), policy);
        for (const auto& scan : scans) reference.insert(scan);
        for (unsigned threads : {1u, 2u, 3u, 4u})
            expectSameBits<Dim>(mapOf<Dim>(scans, policy, threads).cells, reference.cells());
    }
}

// Many rays a bin, so that some are walked first; and threads that help each other.
TYPED_TEST(Equivalence, DenseScansInThreads) {
    constexpr int Dim = TypeParam::value;
    constexpr int kScans = 2, kRays = 20000;
    const CellGeometry<Dim> g(0.1);
    Random random(81);
    std::vector<RayBundle<Dim>> scans;
    for (int s = 0; s < kScans; ++s) {
        RayBundle<Dim> scan(g, test::uniformPoint<Dim>(random, 0.2));
        for (int i = 0; i < kRays; ++i) {
            Point<Dim> end = test::uniformPoint<Dim>(random, 1.5);
            end[0] = 3 + end[0] / 3;
            scan.add(end, i % 17 == 0 ? RayEnd::noReturn : RayEnd::hit);
        }
        ASSERT_EQ(scan.size(), std::size_t{kRays});
        scans.push_back(std::move(scan));
    }
    for (const UpdatePolicy policy : {UpdatePolicy::everyRay, UpdatePolicy::netEvidence}) {
        ReferenceMapper<Dim> reference(defaultModel(policy), policy);
        for (const auto& scan : scans) reference.insert(scan);
        for (int repetition = 0; repetition < 15; ++repetition)
            for (unsigned threads : {2u, 3u, 8u})
                ASSERT_NO_FATAL_FAILURE(expectSameBits<Dim>(
                    mapOf<Dim>(scans, policy, threads).cells, reference.cells()));
    }
}

TYPED_TEST(Equivalence, HugeExtentsUseTheSparseDirectory) {
    constexpr int Dim = TypeParam::value;
    const CellGeometry<Dim> g(0.01);
    const SensorModel model;
    const double edge = kCellLimit * 0.01;
    RayBundle<Dim> scan(g, Point<Dim>::Constant(-0.9 * edge));
    scan.add(Point<Dim>::Constant(0.9 * edge));
    Point<Dim> other = Point<Dim>::Constant(0.9 * edge);
    other[0] = -0.9 * edge;
    scan.add(other);
    ReferenceMapper<Dim> reference(model);
    reference.insert(scan);
    IntegratorOptions options;
    options.method = Method::full;
    ScanIntegrator<Dim> integrator;
    TestMap<Dim> map;
    map.apply(integrator.integrate(scan, model, options, &map), model, UpdatePolicy::everyRay);
    EXPECT_GT(reference.cells().size(), 2u * 58000);
    expectSameBits<Dim>(map.cells, reference.cells());
}

// From one end of the addressable cells to the other, often enough to settle them;
// then another way, which parts from the first at its far end.
TYPED_TEST(Equivalence, TheLongestRaysHaveSomethingToTellAtTheirEnds) {
    constexpr int Dim = TypeParam::value;
    const CellGeometry<Dim> g(0.01);
    const SensorModel model;
    const Point<Dim> origin = Point<Dim>::Constant((-kCellLimit + 0.5) * 0.01);
    ReferenceMapper<Dim> reference(model);
    ScanIntegrator<Dim> integrator;
    TestMap<Dim> map;
    std::uint64_t culled = 0;
    for (int s = 0; s < 12; ++s) {
        RayBundle<Dim> scan(g, origin);
        for (const std::int32_t cells : {40000, 2 * kCellLimit - 2, 2 * kCellLimit - 1}) {
            Point<Dim> end = origin;
            end[0] += 0.01 * cells;
            for (int a = 1; a < Dim; ++a) end[a] += 0.01 * (s < 6 ? 0.3 : 1.2);
            scan.add(end);
        }
        ASSERT_EQ(scan.size(), 3u);
        reference.insert(scan);
        map.apply(integrator.integrate(scan, model, {}, &map), model, UpdatePolicy::everyRay);
        culled += integrator.statistics().raysCulled;
    }
    EXPECT_GT(reference.cells().size(), 65000u);
    EXPECT_GT(culled, 0u);
    expectSameBits<Dim>(map.cells, reference.cells());
}

TYPED_TEST(Equivalence, EmptyScanTouchesNothing) {
    constexpr int Dim = TypeParam::value;
    ScanIntegrator<Dim> integrator;
    const RayBundle<Dim> scan(CellGeometry<Dim>(0.1), Point<Dim>::Zero());
    EXPECT_EQ(integrator.integrate(scan, SensorModel(), {}, nullptr).blockCount(), 0u);
}

TEST(IntegratorOptions, AreValidated) {
    IntegratorOptions o;
    o.threads = 0;
    EXPECT_THROW(o.validate(), std::invalid_argument);
    o.threads = 1;
    o.superRayThreshold = 0;
    EXPECT_THROW(o.validate(), std::invalid_argument);
    EXPECT_THROW(methodFromString("fast"), std::invalid_argument);
    EXPECT_EQ(methodFromString("auto"), Method::automatic);
    for (Method m : kFastMethods) EXPECT_EQ(methodFromString(toString(m)), m);
}

}  // namespace
}  // namespace superray
