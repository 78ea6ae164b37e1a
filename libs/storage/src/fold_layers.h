#pragma once
/// \file fold_layers.h
/// The inner loop of every storage: counts folded into the cells of a block.

#include <superray/core/block.h>
#include <superray/core/sensor_model.h>

namespace superray {

/// Sensor model and policy as the loop needs them.
struct FoldModel {
    FoldModel(const SensorModel& m, UpdatePolicy p)
        : hit(m.hit()), miss(m.miss()), min(m.min()), max(m.max()), policy(p) {}
    float hit, miss, min, max;
    UpdatePolicy policy;
};

/// Cells of `layers` runs of 64 (one BlockMask word each).
struct FoldTarget {
    float* values;             ///< 0 where not known
    std::uint64_t* known;      ///< cells that are touched become known
    std::uint64_t* saturated;  ///< known cells whose value equals the lower clamp
    int layers;
};

/// value = SensorModel::updated(value, misses, hits) for every touched cell,
/// bit for bit; `saturated` is renewed in layers that are touched.
/// \param misses 64 counts per layer
/// \param hits the same, or nullptr for none
using FoldLayers = void (*)(const FoldModel& model, const FoldTarget& target,
                            const std::uint8_t* misses, const std::uint8_t* hits);

/// The fastest version for this CPU.
FoldLayers foldLayersForThisCpu();
/// Every version this CPU can run, slowest first (tests hold them equal).
struct FoldVersion {
    const char* name;
    FoldLayers fold;
};
int foldVersions(FoldVersion (&versions)[3]);  ///< \return how many

}  // namespace superray
