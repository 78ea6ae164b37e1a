// SPDX-License-Identifier: BSD-3-Clause
// Every method, policy and number of threads against the reference mapper, bit
// for bit, over scans that follow each other into the same map.

#include <superray/core/reference_mapper.h>
#include <superray/core/scan_integrator.h>

#include <gtest/gtest.h>

#include <cstring>

#include "core/dims.h"
#include "core/ray_generators.h"

namespace superray {
namespace {

using test::Random;

/// The smallest map that can feed the culling region.
template <int Dim>
class TestMap : public SaturationSource<Dim> {
 public:
    void apply(const UpdateBatch<Dim>& batch, const SensorModel& model, UpdatePolicy policy) {
        for (std::size_t b = 0; b < batch.blockCount(); ++b) {
            const BlockMask<Dim> touched = batch.touched(b);
            for (int i = 0; i < kBlockCells<Dim>; ++i) {
                if (!touched.test(i)) continue;
                const unsigned hits = batch.hits(b) != nullptr ? batch.hits(b)[i] : 0;
                const Cell<Dim> cell = cellInBlock<Dim>(batch.key(b), i);
                set(cell, model.updated(value(cell), batch.misses(b)[i], hits, policy), model);
            }
        }
    }
    void apply(const CellCountMap<Dim>& counts, const SensorModel& model, UpdatePolicy policy) {
        for (const auto& [cell, n] : counts)
            set(cell, model.updated(value(cell), n.misses, n.hits, policy), model);
    }
    float value(const Cell<Dim>& cell) const {
        const auto it = cells.find(cell);
        return it == cells.end() ? 0 : it->second;
    }
    void set(const Cell<Dim>& cell, float v, const SensorModel& model) {
        cells[cell] = v;
        range_.include({v, v});
        BlockSaturation<Dim>& block = saturated_[blockOf<Dim>(cell)];
        const int i = indexInBlock<Dim>(cell);
        v == model.min() ? block.saturatedFree.set(i) : block.saturatedFree.reset(i);
        block.mayExceedUnknown |= v > 0;
    }
    /// Looks anew which cells are at the lower clamp.
    void use(const SensorModel& model) {
        for (const auto& [cell, v] : std::map<Cell<Dim>, float>(cells)) set(cell, v, model);
    }
    BlockSaturation<Dim> saturation(const BlockKey<Dim>& key, float) const override {
        const auto it = saturated_.find(key);
        return it == saturated_.end() ? BlockSaturation<Dim>{} : it->second;
    }
    LogOddsRange valueRange() const override { return range_; }
    std::map<Cell<Dim>, float> cells;

 private:
    std::unordered_map<BlockKey<Dim>, BlockSaturation<Dim>, IndexHash> saturated_;
    LogOddsRange range_;
};

/// A scan into a map, by integrate() or from exact counts, as needsExactCounts() says.
/// \return whether from exact counts
template <int Dim>
bool insert(const RayBundle<Dim>& scan, const SensorModel& model,
            const IntegratorOptions& options, ScanIntegrator<Dim>& integrator,
            TestMap<Dim>& map) {
    if (ScanIntegrator<Dim>::needsExactCounts(options, model, &map)) {
        map.apply(countCells(scan), model, options.policy);
        return true;
    }
    map.apply(integrator.integrate(scan, model, options, &map), model, options.policy);
    return false;
}

SensorModel defaultModel(UpdatePolicy policy) {
    return SensorModel(SensorProbabilities::defaultsOf(policy));
}

template <int Dim>
void expectSameBits(const std::map<Cell<Dim>, float>& got,
                    const std::map<Cell<Dim>, float>& reference) {
    ASSERT_EQ(got.size(), reference.size());
    for (auto a = got.begin(), b = reference.begin(); a != got.end(); ++a, ++b) {
        ASSERT_EQ(a->first, b->first);
        ASSERT_EQ(std::memcmp(&a->second, &b->second, sizeof(float)), 0)
            << a->second << " " << b->second;
    }
}

constexpr Method kFastMethods[] = {Method::perRay, Method::superRays, Method::culling,
                                   Method::full, Method::automatic};

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

TYPED_TEST(Equivalence, OtherModelsAndThresholds) {
    constexpr int Dim = TypeParam::value;
    const CellGeometry<Dim> g(0.25);
    int models = 0;
    std::uint64_t rays = 0;
    for (double miss : {0.02, 0.3, 0.49}) {
        for (double clampMin : {0.001, 0.4}) {
            ++models;
            SensorProbabilities p;
            p.probMiss = miss;
            p.clampMin = clampMin;
            p.clampMax = 0.9999;
            const SensorModel model(p);
            Random random(60);
            ReferenceMapper<Dim> reference(model);
            std::vector<TestMap<Dim>> maps(std::size(kFastMethods));
            ScanIntegrator<Dim> integrator;
            for (int s = 0; s < 4; ++s) {
                const auto scan = test::makeScan<Dim>(test::kScenes[s % 5], random, g, 400);
                rays += scan.size();
                reference.insert(scan);
                for (std::size_t m = 0; m < maps.size(); ++m) {
                    IntegratorOptions options;
                    options.method = kFastMethods[m];
                    options.superRayThreshold = 1 + static_cast<std::uint32_t>(s);
                    if (ScanIntegrator<Dim>::needsExactCounts(options, model, &maps[m]))
                        continue;
                    maps[m].apply(integrator.integrate(scan, model, options, &maps[m]), model,
                                  UpdatePolicy::everyRay);
                }
            }
            IntegratorOptions options;
            options.method = Method::full;
            if (ScanIntegrator<Dim>::needsExactCounts(options, model, nullptr)) {
                EXPECT_GT(model.missesToSaturate(), UpdateBatch<Dim>::kMaxCount);
                continue;
            }
            for (const TestMap<Dim>& map : maps)
                expectSameBits<Dim>(map.cells, reference.cells());
        }
    }
    EXPECT_EQ(models, 6);
    EXPECT_EQ(rays, 6u * 4 * 400);
}

// Caps and steps of all sizes: one miss says all, or 255 do not; hits outweigh misses at once,
// or never; a scan can take a cell from one clamp to the other, or not move it in float32.
TYPED_TEST(Equivalence, NetEvidenceUnderOtherModels) {
    constexpr int Dim = TypeParam::value;
    constexpr auto kPolicy = UpdatePolicy::netEvidence;
    const CellGeometry<Dim> g(0.2);
    int models = 0, hitCells = 0;
    std::uint64_t comparisons = 0;
    for (const double hit : {0.51, 0.7, 0.9, 0.999})
        for (const double miss : {0.001, 0.4, 0.475, 0.4999})
            for (const double cap : {0.5001, 0.6, 0.9, 0.99999}) {
                SensorProbabilities p;
                p.probHit = hit;
                p.probMiss = miss;
                p.scanHitMax = cap;
                p.scanMissMin = models % 3 == 0 ? 1 - cap : 0.3;
                p.clampMin = models % 2 == 0 ? 0.1192 : 0.4;
                p.clampMax = models % 5 == 0 ? 0.6 : 0.971;
                const SensorModel model(p);
                ++models;
                Random random(61);
                ReferenceMapper<Dim> reference(model, kPolicy);
                struct Case {
                    IntegratorOptions options;
                    TestMap<Dim> map;
                };
                std::vector<Case> cases;
                for (const Method method : kFastMethods)
                    for (const unsigned threads : {1u, 2u}) {
                        cases.emplace_back();
                        cases.back().options.method = method;
                        cases.back().options.policy = kPolicy;
                        cases.back().options.superRayThreshold = 2;
                        cases.back().options.threads = threads;
                    }
                ScanIntegrator<Dim> integrator;
                for (int s = 0; s < 6; ++s) {
                    const auto scan =
                        test::makeScan<Dim>(test::kScenes[(s + models) % 7], random, g, 250);
                    reference.insert(scan);
                    for (Case& c : cases)
                        EXPECT_FALSE(insert(scan, model, c.options, integrator, c.map));
                }
                for (const Case& c : cases) {
                    SCOPED_TRACE(std::string(toString(c.options.method)) + " hit " +
                                 std::to_string(hit) + " miss " + std::to_string(miss) +
                                 " cap " + std::to_string(cap));
                    ASSERT_NO_FATAL_FAILURE(
                        expectSameBits<Dim>(c.map.cells, reference.cells()));
                    ++comparisons;
                }
                for (const auto& entry : reference.cells()) hitCells += entry.second > 0;
            }
    EXPECT_EQ(models, 64);
    EXPECT_EQ(comparisons, 64u * 5 * 2);
    EXPECT_GT(hitCells, 500);
}

// Values outside the clamps: a map that was loaded, or options that have changed. Cells far
// above the upper clamp take more misses to saturate than any between the clamps.
TYPED_TEST(Equivalence, ValuesOutsideTheClamps) {
    constexpr int Dim = TypeParam::value;
    const CellGeometry<Dim> g(0.1);
    std::uint64_t exact = 0, counted = 0;
    for (const UpdatePolicy policy : kUpdatePolicies) {
        const SensorModel model = defaultModel(policy);
        for (const float beyond : {3.0f, 20.0f, 90.0f, 500.0f, 1e30f}) {
            for (const Method method : kFastMethods) {
                for (const unsigned threads : {1u, 3u}) {
                    SCOPED_TRACE(std::string(toString(method)) + " " + toString(policy) + " " +
                                 std::to_string(beyond));
                    Random random(62);
                    TestMap<Dim> map, reference;
                    for (int i = 0; i < 4000; ++i) {
                        Cell<Dim> cell;
                        for (int a = 0; a < Dim; ++a) cell[a] = test::integer(random, -9, 9);
                        const float values[] = {model.max() + beyond, model.min() - beyond,
                                                model.min(), 0.3f};
                        const float v = values[test::integer(random, 0, 3)];
                        map.set(cell, v, model);
                        reference.set(cell, v, model);
                    }
                    IntegratorOptions options;
                    options.method = method;
                    options.policy = policy;
                    options.threads = threads;
                    ScanIntegrator<Dim> integrator;
                    for (const auto scene : {test::Scene::nearby, test::Scene::patch,
                                             test::Scene::uniform, test::Scene::clustered}) {
                        const auto scan = test::makeScan<Dim>(scene, random, g, 400);
                        reference.apply(countCells(scan), model, policy);
                        ++(insert(scan, model, options, integrator, map) ? exact : counted);
                        ASSERT_NO_FATAL_FAILURE(
                            expectSameBits<Dim>(map.cells, reference.cells));
                    }
                }
            }
        }
    }
    EXPECT_EQ(exact + counted, 3u * 5 * 5 * 2 * 4);
    EXPECT_GT(exact, 50u);
    EXPECT_GT(counted, 300u);
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
