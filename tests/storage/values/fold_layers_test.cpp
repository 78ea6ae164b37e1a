// SPDX-License-Identifier: BSD-3-Clause
// Every version of the inner loop equals SensorModel::updated(), bit for bit.

#include "values/fold_layers.h"

#include <cstdlib>
#include "storage/storage_test_tools.h"

namespace superray::test {
namespace {

class FoldLayersTest : public ::testing::TestWithParam<UpdatePolicy> {};

TEST_P(FoldLayersTest, EveryVersionEqualsTheSensorModel) {
    const UpdatePolicy policy = GetParam();
    FoldVersion versions[kMaxFoldVersions];
    const int count = foldVersions(versions);
    ASSERT_GE(count, 1);
    // Unless a lesser instruction set is asked for, the best one is used.
    if (std::getenv("SUPERRAY_INSTRUCTION_SET") == nullptr) {
        EXPECT_STREQ(foldForThisCpu().name, versions[count - 1].name);
    }

    std::mt19937 random{11};
    SensorProbabilities other;
    other.probHit = 0.83;
    other.probMiss = 0.31;
    other.scanHitMax = 0.99;
    other.scanMissMin = 0.01;
    const SensorModel models[] = {SensorModel(), SensorModel(other)};
    std::uint64_t cells = 0;
    for (int round = 0; round < 400; ++round) {
        const SensorModel& model = models[round % 2];
        const float special[] = {model.min(), model.max(), 0.0f, -30.0f, 30.0f, 0.1f};
        std::array<float, 512> values{};
        std::array<std::uint8_t, 512> misses{}, hits{};
        BlockMask<3> known, saturated;
        const unsigned sparse = 1u << (random() % 8);
        for (unsigned i = 0; i < 512; ++i) {
            if (random() % 2) {
                known.set(static_cast<int>(i));
                values[i] = random() % 2 ? special[random() % 6]
                                         : float(random() % 6000) * 0.001f - 2.0f;
                if (values[i] == model.min()) saturated.set(static_cast<int>(i));
            }
            if (random() % sparse == 0) misses[i] = static_cast<std::uint8_t>(random());
            if (random() % sparse == 0) hits[i] = static_cast<std::uint8_t>(random());
        }
        const bool anyHits = round % 3 != 0;
        const int layers = round % 5 == 0 ? 1 : 8;
        for (int v = 0; v < count; ++v) {
            auto got = values;
            BlockMask<3> gotKnown = known, gotSaturated = saturated;
            BlockMask<3> touched;
            float* layerValues[8];
            for (int z = 0; z < 8; ++z) layerValues[z] = got.data() + 64 * z;
            const std::uint8_t* hitsOrNone = anyHits ? hits.data() : nullptr;
            versions[v].touchedCells(layers, misses.data(), hitsOrNone, touched.words.data());
            versions[v].foldCounts(FoldModel(model, policy),
                                   {layers, layerValues, touched.words.data(),
                                    gotKnown.words.data(), gotSaturated.words.data()},
                                   misses.data(), hitsOrNone);
            for (unsigned i = 0; i < 512; ++i, ++cells) {
                const int at = static_cast<int>(i);
                const std::uint32_t m = at < 64 * layers ? misses[i] : 0;
                const std::uint32_t h = at < 64 * layers && anyHits ? hits[i] : 0;
                const float expected = model.updated(values[i], m, h, policy);
                ASSERT_EQ(touched.test(at), m || h) << versions[v].name;
                const bool isKnown = known.test(at) || m || h;
                ASSERT_EQ(bitsOf(got[i]), bitsOf(expected)) << versions[v].name;
                ASSERT_EQ(gotKnown.test(at), isKnown) << versions[v].name;
                ASSERT_EQ(gotSaturated.test(at), isKnown && expected == model.min())
                    << versions[v].name;
            }
        }
    }
    EXPECT_EQ(cells, 400u * 512u * static_cast<unsigned>(count));
}

INSTANTIATE_TEST_SUITE_P(Policies, FoldLayersTest, ::testing::ValuesIn(kUpdatePolicies),
                         [](const auto& c) { return std::string(toString(c.param)); });

}  // namespace
}  // namespace superray::test
