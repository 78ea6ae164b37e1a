// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file fold_layers.h
/// The inner loop of the block grid: counts folded into the cells of a block,
/// in layers of 64 cells (one BlockMask word each).

#include <superray/core/block.h>
#include <superray/core/sensor_model.h>

namespace superray {

/// Sensor model and policy as the loop needs them.
struct FoldModel {
    FoldModel(const SensorModel& m, UpdatePolicy p)
        : hit(m.hit()),
          miss(m.miss()),
          min(m.min()),
          max(m.max()),
          scanHit(m.scanHit()),
          scanMiss(m.scanMiss()),
          policy(p) {}
    float hit, miss, min, max, scanHit, scanMiss;
    UpdatePolicy policy;
};

/// A block; arrays have one entry per layer.
struct FoldTarget {
    int layers;
    float* const* values;          ///< 64 per touched layer, 0 where not known
    const std::uint64_t* touched;  ///< cells with a count
    std::uint64_t* known;          ///< touched cells become known
    std::uint64_t* saturated;      ///< known cells whose value equals the lower clamp
};

/// The loop for one instruction set.
struct FoldVersion {
    const char* name;
    /// Cells with a miss or a hit. \param hits nullptr for none
    void (*touchedCells)(int layers, const std::uint8_t* misses, const std::uint8_t* hits,
                         std::uint64_t* touched);
    /// value = SensorModel::updated(value, misses, hits) for every touched cell,
    /// bit for bit.
    void (*foldCounts)(const FoldModel& model, const FoldTarget& target,
                       const std::uint8_t* misses, const std::uint8_t* hits);
};

/// Leaves out touched cells that are saturated and not hit: misses change
/// nothing there. \param hits of the block's cells, nullptr for none
template <int Dim>
void leaveOutSaturated(const FoldVersion& fold, BlockMask<Dim>& touched,
                       const BlockMask<Dim>& saturated, const std::uint8_t* hits) {
    BlockMask<Dim> hit;
    if (hits != nullptr)
        fold.touchedCells(BlockMask<Dim>::kWords, hits, nullptr, hit.words.data());
    for (std::size_t w = 0; w < touched.words.size(); ++w)
        touched.words[w] &= ~saturated.words[w] | hit.words[w];
}

/// The version for instructionSet(): the fastest one, unless the user asks for
/// a lesser set.
const FoldVersion& foldForThisCpu();
/// Every version this CPU can run, slowest first (tests hold them equal).
inline constexpr int kMaxFoldVersions = 4;
int foldVersions(FoldVersion (&versions)[kMaxFoldVersions]);  ///< \return how many

}  // namespace superray
