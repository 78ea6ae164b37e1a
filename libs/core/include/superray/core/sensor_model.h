// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file sensor_model.h
/// Inverse sensor model and update policies (paper Sec. III-A; design rules 4, 5).

#include <cstdint>
#include <string>

namespace superray {

/// How the rays of one scan act on a cell.
enum class UpdatePolicy : std::uint8_t {
    everyRay,    ///< each ray counts (the paper): L += m * l_miss, then L += h * l_hit
    oncePerScan  ///< m, h in {0, 1}; a hit cell is not missed (OctoMap's insertPointCloud)
};

/// Probabilities as users give them; the defaults are the paper's.
struct SensorProbabilities {
    double probHit = 0.7;
    double probMiss = 0.4;
    double clampMin = 0.1192;
    double clampMax = 0.971;
    double occupancyThreshold = 0.5;
};

/// Validated log-odds, in float32 as every map stores them.
class SensorModel {
 public:
    SensorModel() : SensorModel(SensorProbabilities{}) {}

    /// \throws std::invalid_argument naming the option, its value and the rule:
    /// 0.5 < probHit < 1, 0 < probMiss < 0.5, 0 < clampMin < clampMax < 1 with
    /// clampMin < 0.5 < clampMax, 0 < occupancyThreshold < 1.
    explicit SensorModel(const SensorProbabilities& p);

    const SensorProbabilities& probabilities() const { return probabilities_; }
    float hit() const { return hit_; }            ///< l_hit > 0
    float miss() const { return miss_; }          ///< l_miss < 0
    float min() const { return min_; }            ///< l_min, the lower clamp
    float max() const { return max_; }            ///< l_max, the upper clamp
    float occupied() const { return occupied_; }  ///< occupied if L >= this

    /// Fewest misses that take any value to l_min: more change nothing.
    std::uint32_t missesToSaturate() const { return missesToSaturate_; }
    /// Fewest misses that take an unknown cell, or any value <= 0, to l_min.
    std::uint32_t missesToSaturateUnknown() const { return missesToSaturateUnknown_; }
    /// Fewest hits that take any value to l_max.
    std::uint32_t hitsToSaturate() const { return hitsToSaturate_; }

    /// Design rule 4 and 5 for one cell: the one definition of an update.
    /// \param value current log-odds; 0 for an unknown cell
    float updated(float value, std::uint32_t misses, std::uint32_t hits,
                  UpdatePolicy policy) const {
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
    float hit_, miss_, min_, max_, occupied_;
    std::uint32_t missesToSaturate_, missesToSaturateUnknown_, hitsToSaturate_;
};

/// log(p / (1 - p)) in float32, as OctoMap computes it.
float logOddsOf(double probability);
/// Inverse of logOddsOf.
double probabilityOf(float logOdds);

UpdatePolicy updatePolicyFromString(
    const std::string& name);  ///< \throws std::invalid_argument
const char* toString(UpdatePolicy policy);

}  // namespace superray
