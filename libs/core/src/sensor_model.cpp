// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/sensor_model.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <stdexcept>

namespace superray {
namespace {

void require(bool rule, const char* name, double value, const char* text) {
    if (rule) return;
    std::ostringstream message;
    message << name << " = " << value << ": must satisfy " << text;
    throw std::invalid_argument(message.str());
}

std::uint32_t stepsToCross(float span, float step) {
    const double n =
        std::ceil(std::max(0.0, static_cast<double>(span)) / static_cast<double>(step));
    // One more than the quotient: float32 rounding cannot make it too few.
    return n < 4e9 ? static_cast<std::uint32_t>(n) + 1 : 0xFFFFFFFFu;
}

}  // namespace

SensorProbabilities SensorProbabilities::defaultsOf(UpdatePolicy policy) {
    SensorProbabilities p;
    if (policy == UpdatePolicy::netEvidence) {
        p.probHit = 0.9;
        p.probMiss = 0.475;
        p.clampMin = p.scanMissMin;
    }
    return p;
}

SensorModel::SensorModel(const SensorProbabilities& p) : probabilities_(p) {
    require(p.probHit > 0.5 && p.probHit < 1, "probHit", p.probHit, "0.5 < probHit < 1");
    require(p.probMiss > 0 && p.probMiss < 0.5, "probMiss", p.probMiss, "0 < probMiss < 0.5");
    require(p.clampMin > 0 && p.clampMin < 0.5, "clampingThresMin", p.clampMin,
            "0 < clampingThresMin < 0.5");
    require(p.clampMax > 0.5 && p.clampMax < 1, "clampingThresMax", p.clampMax,
            "0.5 < clampingThresMax < 1");
    require(p.occupancyThreshold > 0 && p.occupancyThreshold < 1, "occupancyThres",
            p.occupancyThreshold, "0 < occupancyThres < 1");
    require(p.scanHitMax > 0.5 && p.scanHitMax < 1, "scanHitMax", p.scanHitMax,
            "0.5 < scanHitMax < 1");
    require(p.scanMissMin > 0 && p.scanMissMin < 0.5, "scanMissMin", p.scanMissMin,
            "0 < scanMissMin < 0.5");
    hit_ = logOddsOf(p.probHit);
    miss_ = logOddsOf(p.probMiss);
    min_ = logOddsOf(p.clampMin);
    max_ = logOddsOf(p.clampMax);
    occupied_ = logOddsOf(p.occupancyThreshold);
    scanHit_ = logOddsOf(p.scanHitMax);
    scanMiss_ = logOddsOf(p.scanMissMin);
    require(hit_ > 0, "probHit", p.probHit, "log-odds > 0 in float32");
    require(miss_ < 0, "probMiss", p.probMiss, "log-odds < 0 in float32");
    require(min_ < 0, "clampingThresMin", p.clampMin, "log-odds < 0 in float32");
    require(max_ > 0, "clampingThresMax", p.clampMax, "log-odds > 0 in float32");
    require(scanHit_ > 0, "scanHitMax", p.scanHitMax, "log-odds > 0 in float32");
    require(scanMiss_ < 0, "scanMissMin", p.scanMissMin, "log-odds < 0 in float32");
    missesToSaturateUnknown_ = stepsToCross(-min_, -miss_);
    while (missesToSaturateUnknown_ > 1 &&
           updated(0, missesToSaturateUnknown_ - 1, 0, UpdatePolicy::everyRay) == min_)
        --missesToSaturateUnknown_;
}

std::uint32_t SensorModel::missesToSaturate(float highest) const {
    return stepsToCross(highest - min_, -miss_);
}

std::uint32_t SensorModel::hitsToSaturate(float lowest) const {
    return stepsToCross(max_ - lowest, hit_);
}

float logOddsOf(double probability) {
    return static_cast<float>(std::log(probability / (1.0 - probability)));
}

double probabilityOf(float logOdds) {
    return 1.0 - 1.0 / (1.0 + std::exp(static_cast<double>(logOdds)));
}

UpdatePolicy updatePolicyFromString(const std::string& name) {
    for (const UpdatePolicy policy : kUpdatePolicies)
        if (name == toString(policy)) return policy;
    throw std::invalid_argument("policy = \"" + name + "\": must be " + updatePolicyNames());
}

std::string updatePolicyNames() {
    std::string names;
    for (const UpdatePolicy policy : kUpdatePolicies) {
        if (policy != *std::begin(kUpdatePolicies))
            names += policy == *std::rbegin(kUpdatePolicies) ? " or " : ", ";
        names += toString(policy);
    }
    return names;
}

const char* toString(UpdatePolicy policy) {
    switch (policy) {
        case UpdatePolicy::everyRay:
            return "everyRay";
        case UpdatePolicy::oncePerScan:
            return "oncePerScan";
        case UpdatePolicy::netEvidence:
            break;
    }
    return "netEvidence";
}

}  // namespace superray
