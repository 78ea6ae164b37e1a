// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/sensor_model.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace superray {
namespace {

TEST(SensorModel, DefaultsAreThePapers) {
    const SensorModel m;
    EXPECT_NEAR(m.hit(), 0.85, 0.005);
    EXPECT_NEAR(m.miss(), -0.4, 0.006);
    EXPECT_NEAR(m.min(), -2, 0.001);
    EXPECT_NEAR(m.max(), 3.5, 0.02);
    EXPECT_EQ(m.occupied(), 0.0f);
}

TEST(SensorModel, MissesComeBeforeHitsAndBothClamp) {
    const SensorModel m;
    using P = UpdatePolicy;
    EXPECT_EQ(m.updated(0, 1, 0, P::everyRay), m.miss());
    EXPECT_EQ(m.updated(0, 3, 0, P::everyRay), 3.0f * m.miss());
    EXPECT_EQ(m.updated(0, 100, 0, P::everyRay), m.min());
    EXPECT_EQ(m.updated(0, 100, 1, P::everyRay), m.min() + m.hit());
    EXPECT_EQ(m.updated(1, 0, 100, P::everyRay), m.max());
    EXPECT_EQ(m.updated(1, 0, 0, P::everyRay), 1.0f);
    // Once per scan: a hit cell is not missed.
    EXPECT_EQ(m.updated(0, 100, 100, P::oncePerScan), m.hit());
    EXPECT_EQ(m.updated(0, 100, 0, P::oncePerScan), m.miss());
}

TEST(SensorModel, NetEvidenceWeighsHitsAgainstMissesAndCapsTheScan) {
    const auto net = UpdatePolicy::netEvidence;
    const SensorModel m(SensorProbabilities::defaultsOf(net));
    EXPECT_NEAR(m.hit(), 2.197, 0.001);
    EXPECT_NEAR(m.miss(), -0.100, 0.001);
    EXPECT_EQ(m.updated(0.25f, 0, 0, net), 0.25f);
    EXPECT_EQ(m.updated(0, 3, 0, net), 3.0f * m.miss());
    EXPECT_EQ(m.updated(0, 3, 1, net), m.hit() + 3.0f * m.miss());
    EXPECT_EQ(m.updated(0, 0, 7, net), m.scanHit());
    EXPECT_EQ(m.updated(0, 200, 0, net), m.scanMiss());
    // One clear scan makes a cell free (p < 0.3); one hit among 21 misses leaves it occupied.
    EXPECT_LT(probabilityOf(m.updated(0, 9, 0, net)), 0.3);
    EXPECT_GT(m.updated(0, 21, 1, net), 0);
    EXPECT_LT(m.updated(0, 23, 1, net), 0);
    // Both clamps hold; counts are cut at 255.
    EXPECT_EQ(m.updated(m.max(), 0, 1, net), m.max());
    EXPECT_EQ(m.updated(m.min(), 9, 0, net), m.min());
    EXPECT_EQ(m.updated(m.min(), 5, 1, net), m.min() + m.evidence(5, 1));
    EXPECT_EQ(m.evidence(1000, 11), m.evidence(255, 11));
    EXPECT_EQ(m.evidence(255, 1000), m.evidence(255, 255));
}

TEST(SensorModel, MoreUpdatesThanToSaturateChangeNothing) {
    int models = 0;
    for (double miss : {0.01, 0.3, 0.4, 0.49, 0.499}) {
        for (double hit : {0.51, 0.7, 0.97}) {
            SensorProbabilities p;
            p.probMiss = miss;
            p.probHit = hit;
            const SensorModel m(p);
            const auto every = UpdatePolicy::everyRay;
            EXPECT_EQ(m.updated(m.max(), m.missesToSaturate(), 0, every), m.min());
            const std::uint32_t unknown = m.missesToSaturateUnknown();
            EXPECT_EQ(m.updated(0, unknown, 0, every), m.min());
            EXPECT_EQ(m.updated(m.min() / 3, unknown, 0, every), m.min());
            // Not one too many (for a single one there is nothing fewer).
            EXPECT_TRUE(unknown == 1 || m.updated(0, unknown - 1, 0, every) > m.min());
            EXPECT_EQ(m.updated(m.min(), 0, m.hitsToSaturate(), every), m.max());
            ++models;
        }
    }
    EXPECT_EQ(models, 15);
    EXPECT_LE(SensorModel().missesToSaturate(), 15u);
}

TEST(SensorModel, BadProbabilitiesAreNamed) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    struct Case {
        double SensorProbabilities::*field;
        double value;
        const char* name;
    };
    const Case cases[] = {
        {&SensorProbabilities::probHit, 0.5, "probHit"},
        {&SensorProbabilities::probHit, 1.0, "probHit"},
        {&SensorProbabilities::probHit, nan, "probHit"},
        {&SensorProbabilities::probMiss, 0.5, "probMiss"},
        {&SensorProbabilities::probMiss, 0.0, "probMiss"},
        {&SensorProbabilities::probMiss, nan, "probMiss"},
        {&SensorProbabilities::clampMin, 0.98, "clampingThresMin"},
        {&SensorProbabilities::clampMin, 0.0, "clampingThresMin"},
        {&SensorProbabilities::clampMax, 0.1, "clampingThresMax"},
        {&SensorProbabilities::clampMax, 1.0, "clampingThresMax"},
        {&SensorProbabilities::occupancyThreshold, 0.0, "occupancyThres"},
        {&SensorProbabilities::occupancyThreshold, nan, "occupancyThres"},
        {&SensorProbabilities::scanHitMax, 0.5, "scanHitMax"},
        {&SensorProbabilities::scanHitMax, 1.0, "scanHitMax"},
        {&SensorProbabilities::scanHitMax, nan, "scanHitMax"},
        {&SensorProbabilities::scanMissMin, 0.5, "scanMissMin"},
        {&SensorProbabilities::scanMissMin, 0.0, "scanMissMin"},
        {&SensorProbabilities::scanMissMin, nan, "scanMissMin"},
    };
    for (const Case& c : cases) {
        SensorProbabilities p;
        p.*c.field = c.value;
        try {
            SensorModel m(p);
            FAIL() << c.name << " " << c.value;
        } catch (const std::invalid_argument& e) {
            EXPECT_NE(std::string(e.what()).find(c.name), std::string::npos) << e.what();
        }
    }
}

TEST(SensorModel, PolicyNames) {
    for (auto p : kUpdatePolicies) EXPECT_EQ(updatePolicyFromString(toString(p)), p);
    EXPECT_THROW(updatePolicyFromString("sometimes"), std::invalid_argument);
}

}  // namespace
}  // namespace superray
