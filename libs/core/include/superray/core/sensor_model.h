// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file sensor_model.h
/// Inverse sensor model and update policies (paper Sec. III-A; design rules 4, 5).

#include <algorithm>
#include <cstdint>
#include <string>

namespace superray {

/// How the rays of one scan act on a cell.
enum class UpdatePolicy : std::uint8_t {
    everyRay,     ///< each ray counts (the paper): L += m * l_miss, then L += h * l_hit
    oncePerScan,  ///< m, h in {0, 1}; a hit cell is not missed (OctoMap's insertPointCloud)
    /// The misses and hits of a scan speak together, and no scan more than its caps allow:
    /// L += max(l_scanMiss, min(l_scanHit, h * l_hit + m * l_miss)), with m, h <= 255.
    netEvidence
};
inline constexpr UpdatePolicy kUpdatePolicies[] = {
    UpdatePolicy::everyRay, UpdatePolicy::oncePerScan, UpdatePolicy::netEvidence};

/// Probabilities as users give them; the defaults are the paper's.
struct SensorProbabilities {
    double probHit = 0.7;
    double probMiss = 0.4;
    double clampMin = 0.1192;
    double clampMax = 0.971;
    double occupancyThreshold = 0.5;
    /// Policy netEvidence only: what one scan can make of an unknown cell.
    double scanHitMax = 0.9;
    double scanMissMin = 0.293;

    /// What suits a policy. For everyRay and oncePerScan these are the paper's, as above. For
    /// netEvidence, probHit = 0.9 and probMiss = 0.475: a cell with surface in it ends about
    /// one ray in ten that reach it, and a free one about one in a hundred. Its lower clamp is
    /// scanMissMin: one clear scan makes a cell as free as it gets, and settles it.
    static SensorProbabilities defaultsOf(UpdatePolicy policy);
};

/// Validated log-odds, in float32 as every map stores them.
class SensorModel {
 public:
    SensorModel() : SensorModel(SensorProbabilities{}) {}

    /// \throws std::invalid_argument naming the option, its value and the rule:
    /// 0.5 < probHit < 1, 0 < probMiss < 0.5, 0 < clampMin < clampMax < 1 with
    /// clampMin < 0.5 < clampMax, 0 < occupancyThreshold < 1, 0.5 < scanHitMax < 1,
    /// 0 < scanMissMin < 0.5.
    explicit SensorModel(const SensorProbabilities& p);

    const SensorProbabilities& probabilities() const { return probabilities_; }
    float hit() const { return hit_; }            ///< l_hit > 0
    float miss() const { return miss_; }          ///< l_miss < 0
    float min() const { return min_; }            ///< l_min, the lower clamp
    float max() const { return max_; }            ///< l_max, the upper clamp
    float occupied() const { return occupied_; }  ///< occupied if L >= this
    float scanHit() const { return scanHit_; }    ///< l_scanHit > 0: most that a scan adds
    float scanMiss() const { return scanMiss_; }  ///< l_scanMiss < 0: most that it takes off

    /// Counts beyond this are cut by netEvidence.
    static constexpr std::uint32_t kMostCounted = 255;

    /// Fewest misses that take any value up to `highest` to l_min: more change nothing.
    std::uint32_t missesToSaturate(float highest) const;
    /// The same for any value up to the upper clamp.
    std::uint32_t missesToSaturate() const { return missesToSaturate(max_); }
    /// Fewest misses that take an unknown cell, or any value <= 0, to l_min.
    std::uint32_t missesToSaturateUnknown() const { return missesToSaturateUnknown_; }
    /// Fewest hits that take any value from `lowest` on to l_max.
    std::uint32_t hitsToSaturate(float lowest) const;
    /// The same for any value from the lower clamp on.
    std::uint32_t hitsToSaturate() const { return hitsToSaturate(min_); }

    /// What a scan says of a cell under netEvidence [log-odds].
    float evidence(std::uint32_t misses, std::uint32_t hits) const {
        const float h = static_cast<float>(std::min(hits, kMostCounted)) * hit_;
        const float m = static_cast<float>(std::min(misses, kMostCounted)) * miss_;
        const float sum = h + m;
        const float capped = sum < scanHit_ ? sum : scanHit_;
        return capped > scanMiss_ ? capped : scanMiss_;
    }

    /// The most that an unknown cell can have after misses alone, under any policy.
    float afterFewestMisses() const {
        return std::max({updated(0, 1, 0, UpdatePolicy::everyRay),
                         updated(0, 1, 0, UpdatePolicy::netEvidence)});
    }

    /// Design rule 4 and 5 for one cell: the one definition of an update.
    /// \param value current log-odds; 0 for an unknown cell
    float updated(float value, std::uint32_t misses, std::uint32_t hits,
                  UpdatePolicy policy) const {
        if (policy == UpdatePolicy::netEvidence) {
            if (misses == 0 && hits == 0) return value;
            const float sum = value + evidence(misses, hits);
            const float high = sum < max_ ? sum : max_;
            return high > min_ ? high : min_;
        }
        if (policy == UpdatePolicy::oncePerScan) {
            hits = hits > 0 ? 1 : 0;
            misses = hits == 0 && misses > 0 ? 1 : 0;
        }
        if (misses > 0) {
            const float sum = value + static_cast<float>(misses) * miss_;
            value = sum > min_ ? sum : min_;
        }
        if (hits > 0) {
            const float sum = value + static_cast<float>(hits) * hit_;
            value = sum < max_ ? sum : max_;
        }
        return value;
    }

 private:
    SensorProbabilities probabilities_;
    float hit_, miss_, min_, max_, occupied_, scanHit_, scanMiss_;
    std::uint32_t missesToSaturateUnknown_;
};

/// log(p / (1 - p)) in float32, as OctoMap computes it.
float logOddsOf(double probability);
/// Inverse of logOddsOf.
double probabilityOf(float logOdds);

UpdatePolicy updatePolicyFromString(
    const std::string& name);  ///< \throws std::invalid_argument
const char* toString(UpdatePolicy policy);
/// "everyRay, oncePerScan or netEvidence", for messages.
std::string updatePolicyNames();

}  // namespace superray
