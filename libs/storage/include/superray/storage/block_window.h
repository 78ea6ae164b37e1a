// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file block_window.h
/// The blocks around a sensor that a sliding window keeps.

#include <superray/core/block.h>

#include <algorithm>
#include <cstdint>

namespace superray {

/// A ball of whole blocks around the block of the sensor.
///
/// Block k is in the window if the gap between its box and the box of the sensor's block
/// is at most the radius. With d = max(0, |k - sensor| - 1) per axis, in blocks, that is
/// |d| * block edge <= radius. So nothing within the radius of the sensor is outside the
/// window, and nothing is inside that is farther than the radius and two block diagonals.
template <int Dim>
class BlockWindow {
 public:
    /// What a box of blocks has in common with the window.
    enum class Overlap : std::uint8_t { none, part, whole };

    /// \param radius [m], >= 0; may be infinite
    /// \param resolution edge of a cell [m]
    BlockWindow(const BlockKey<Dim>& sensor, double radius, double resolution)
        : sensor_(sensor) {
        const double blocks = radius / (kBlockEdge * resolution);
        squaredBlocks_ = blocks * blocks;
    }

    bool holds(const BlockKey<Dim>& key) const {
        return static_cast<double>(squaredGap(key, key).nearest) <= squaredBlocks_;
    }

    /// \param lowest,highest the corners of a box of blocks, inclusive
    Overlap overlap(const BlockKey<Dim>& lowest, const BlockKey<Dim>& highest) const {
        const SquaredGap gap = squaredGap(lowest, highest);
        if (static_cast<double>(gap.farthest) <= squaredBlocks_) return Overlap::whole;
        return static_cast<double>(gap.nearest) <= squaredBlocks_ ? Overlap::part
                                                                  : Overlap::none;
    }

 private:
    /// Squared gap [blocks^2] of the nearest and of the farthest block of a box.
    struct SquaredGap {
        std::int64_t nearest = 0, farthest = 0;
    };
    SquaredGap squaredGap(const BlockKey<Dim>& lowest, const BlockKey<Dim>& highest) const {
        SquaredGap gap;
        for (std::size_t a = 0; a < Dim; ++a) {
            const std::int64_t below = std::int64_t{sensor_[a]} - lowest[a];
            const std::int64_t above = std::int64_t{highest[a]} - sensor_[a];
            const std::int64_t near = std::max<std::int64_t>({0, -below - 1, -above - 1});
            const std::int64_t far = std::max<std::int64_t>({0, below - 1, above - 1});
            gap.nearest += near * near;
            gap.farthest += far * far;
        }
        return gap;
    }

    BlockKey<Dim> sensor_;
    double squaredBlocks_;
};

}  // namespace superray
