// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file culling_region.h
/// Culling region (paper Sec. IV-B): the cells from which every way to the
/// sensor leads through fully-free cells only.

#include <superray/core/block.h>
#include <superray/core/ray_line.h>

#include <functional>
#include <memory>

namespace superray {

/// A cell belongs to the region if it is saturated free and each neighbour one
/// step nearer to the sensor's cell (one per axis on which they differ) does.
/// So the part of any ray from the sensor that lies in the region is a prefix
/// of its walk, and misses there change nothing.
///
/// Built block by block, nearest first, a row of 8 cells at a time.
template <int Dim>
class CullingRegion {
 public:
    /// Tells which cells of a block are saturated free; nullptr: none. What it
    /// points at need last only until the next call.
    using Saturation = std::function<const BlockMask<Dim>*(const BlockKey<Dim>&)>;

    CullingRegion();
    ~CullingRegion();
    CullingRegion(CullingRegion&&) noexcept;
    CullingRegion& operator=(CullingRegion&&) noexcept;

    /// Rebuilds the region around `sensor`, limited to the blocks of the
    /// inclusive cell bounds [lowest, highest] (the extent of the scan).
    void build(const Cell<Dim>& sensor, const Cell<Dim>& lowest, const Cell<Dim>& highest,
               const Saturation& saturation);
    /// Makes the region empty.
    void clear();

    bool empty() const { return cells_ == 0; }
    std::uint64_t cellCount() const { return cells_; }
    const Cell<Dim>& sensor() const { return sensor_; }
    bool contains(const Cell<Dim>& cell) const;
    /// Cells of a block whose every neighbour one step nearer to the sensor is
    /// in the region; nullptr: none. A ray from the sensor's cell that ends in
    /// such a cell changes nothing but its end cell, whichever way it goes.
    const BlockMask<Dim>* enclosed(const BlockKey<Dim>& key) const;

    /// The last slice of the ray that is entered inside the region (0 if
    /// none): all cells before that slice need no update.
    /// \param hint a guess (the previous ray's answer makes it fast)
    /// \pre the ray starts in the cell sensor()
    std::int32_t firstSliceToWalk(const RayLine<Dim>& line, std::int32_t hint) const;

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
    Cell<Dim> sensor_{};
    std::uint64_t cells_ = 0;
};

extern template class CullingRegion<2>;
extern template class CullingRegion<3>;

}  // namespace superray
