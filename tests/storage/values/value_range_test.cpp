// SPDX-License-Identifier: BSD-3-Clause
// Bounds of the values of a map, which tell how many updates saturate its cells; and scans into
// maps that have values outside the clamps.

#include <superray/core/reference_mapper.h>
#include <superray/core/scan_integrator.h>

#include "core/ray_generators.h"
#include "storage/storage_test_tools.h"

namespace superray::test {
namespace {

template <typename Case>
class ValueRange : public ::testing::Test {
 protected:
    typename Case::Map map_{CellGeometry<Case::Dim>(0.1)};

    void expectRange(float lowest, float highest) const {
        EXPECT_EQ(map_.valueRange().lowest, lowest);
        EXPECT_EQ(map_.valueRange().highest, highest);
    }
};
TYPED_TEST_SUITE(ValueRange, AllStorages);

TYPED_TEST(ValueRange, FollowsWhatIsSetAppliedExchangedAndCleared) {
    constexpr int Dim = TypeParam::Dim;
    const SensorModel model;
    this->expectRange(0, 0);
    this->map_.setLogOdds({}, 7.5f);
    this->expectRange(0, 7.5f);
    std::array<float, kBlockCells<Dim>> values{};
    values[3] = -9;
    values[4] = 11;  // not known
    BlockView<Dim> block{{}, values.data(), {}};
    block.known.set(3);
    this->map_.setBlock(block);
    this->expectRange(-9, 7.5f);
    EXPECT_THROW(this->map_.setLogOdds({}, std::numeric_limits<float>::infinity()),
                 std::invalid_argument);
    this->expectRange(-9, 7.5f);

    typename TypeParam::Map other(this->map_.geometry());
    std::mt19937 random(1);
    other.apply(randomBatch<Dim>(random, 3), model, UpdatePolicy::everyRay);
    EXPECT_EQ(this->map_.clone()->valueRange().lowest, -9);
    this->map_.swapContents(other);
    this->expectRange(model.min(), model.max());
    EXPECT_EQ(other.valueRange().highest, 7.5f);
    other.clear();
    EXPECT_EQ(other.valueRange().highest, 0);
}

TYPED_TEST(ValueRange, ScansIntoMapsWithValuesOutsideTheClampsAreExact) {
    constexpr int Dim = TypeParam::Dim;
    const CellGeometry<Dim> geometry(0.1);
    std::uint64_t exact = 0, counted = 0;
    for (const UpdatePolicy policy : kUpdatePolicies) {
        const SensorModel model(SensorProbabilities::defaultsOf(policy));
        for (const float beyond : {5.0f, 60.0f, 400.0f}) {
            Random random(9);
            typename TypeParam::Map map(geometry);
            Cells<Dim> oracle;
            for (int i = 0; i < 2000; ++i) {
                Cell<Dim> cell;
                for (auto& c : cell) c = integer(random, -9, 9);
                const float value = i % 3 == 0   ? model.max() + beyond
                                    : i % 3 == 1 ? model.min() - beyond
                                                 : model.min();
                map.setLogOdds(cell, value);
                oracle[cell] = value;
            }
            ScanIntegrator<Dim> integrator;
            IntegratorOptions options;
            options.policy = policy;
            for (const Scene scene : {Scene::nearby, Scene::uniform, Scene::patch}) {
                const auto scan = makeScan<Dim>(scene, random, geometry, 500);
                const auto counts = countCells(scan);
                for (const auto& [cell, n] : counts)
                    oracle[cell] = model.updated(oracle[cell], n.misses, n.hits, policy);
                if (ScanIntegrator<Dim>::needsExactCounts(options, model, &map)) {
                    map.OccupancyMap<Dim>::apply(counts, model, policy);
                    ++exact;
                } else {
                    map.apply(integrator.integrate(scan, model, options, &map), model, policy);
                    ++counted;
                }
                ASSERT_TRUE(equalsOracle<Dim>(map, oracle))
                    << toString(policy) << " " << beyond;
            }
        }
    }
    EXPECT_EQ(exact + counted, 3u * 3 * 3);
    EXPECT_EQ(exact, 3u);
}

}  // namespace
}  // namespace superray::test
