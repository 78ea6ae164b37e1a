// SPDX-License-Identifier: BSD-3-Clause
// Every method against the reference mapper, bit for bit, under sensor models of all kinds, and
// in maps with values outside the clamps.

#include "core/dims.h"
#include "core/ray_generators.h"
#include "core/test_map.h"

namespace superray {
namespace {

using namespace test;

template <typename T>
class ModelEquivalence : public ::testing::Test {};
TYPED_TEST_SUITE(ModelEquivalence, test::Dims);

TYPED_TEST(ModelEquivalence, OtherModelsAndThresholds) {
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
TYPED_TEST(ModelEquivalence, NetEvidenceUnderOtherModels) {
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
TYPED_TEST(ModelEquivalence, ValuesOutsideTheClamps) {
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

}  // namespace
}  // namespace superray
