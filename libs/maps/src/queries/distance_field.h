// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file distance_field.h
/// The nearest occupied cell of every cell, up to a reach.

#include <superray/maps/change_log.h>
#include <superray/storage/occupancy_map.h>

#include <memory>
#include <mutex>
#include <shared_mutex>
#include <unordered_map>
#include <utility>
#include <vector>

namespace superray {

/// For each cell, the offset to the occupied cell nearest by the distance of
/// centres, found exactly (ties: any of them).
///
/// Kept in blocks that are computed when first asked for. A change of the map
/// drops the blocks within reach of the cells that became occupied or ceased to
/// be, and nothing else. There are two layers: most questions are about cells at
/// obstacles, and the near layer, which reaches a few cells, answers these at a
/// fraction of the cost. nearest() may be called concurrently.
template <int Dim>
class DistanceField {
 public:
    static constexpr int kMaxReach = 31;     ///< [cells]: an offset takes 6 bits per axis
    static constexpr double kNearReach = 4;  ///< [cells] of the near layer

    /// The occupied cells of all blocks that have one.
    using OccupiedBlocks = std::unordered_map<BlockKey<Dim>, BlockMask<Dim>, IndexHash>;

    /// What the field describes.
    struct Source {
        const OccupancyMap<Dim>& map;
        const ChangeLog<Dim>& changes;
        float occupied;  ///< log-odds from which a cell is occupied
    };

    /// Squared distance and offset in one number, ordered by distance.
    struct Code {
        std::int32_t bits = kNothing;
        bool found() const { return bits != kNothing; }
        int squaredCells() const { return bits >> kSquareShift; }
        Cell<Dim> offset() const {
            Cell<Dim> o;
            for (int a = 0; a < Dim; ++a)
                o[static_cast<std::size_t>(a)] = ((bits >> (kAxisBits * a)) & 63) - kMaxReach;
            return o;
        }
    };

    /// The smallest reach [cells] that finds every cell with a point within
    /// `metres` of any point of the asking cell; at most kMaxReach.
    static double reachFor(double metres, double resolution);

    /// codes[i] of cells[i]: nothing is found beyond the reach.
    /// \param reach [cells], >= 0; a field that reaches farther may find more
    /// \pre cells are addressable; 0 <= reach <= kMaxReach
    void nearest(const Source& source, double reach, const Cell<Dim>* cells, std::size_t count,
                 Code* codes);

    /// Visits (key, occupied cells) of all blocks with an occupied cell.
    template <class Visit>
    void forEachOccupiedBlock(const Source& source, Visit&& visit) {
        const std::unique_lock<std::shared_mutex> lock(mutex_);
        update(source, 0);
        for (const auto& [key, mask] : occupied_) visit(key, mask);
    }

    /// Calls read(blocks), concurrently unless the map has changed.
    template <class Read>
    void readOccupied(const Source& source, Read&& read) {
        {
            const std::shared_lock<std::shared_mutex> lock(mutex_);
            if (isCurrent(source, 0)) return read(std::as_const(occupied_));
        }
        const std::unique_lock<std::shared_mutex> lock(mutex_);
        update(source, 0);
        read(std::as_const(occupied_));
    }

    /// Blocks whose distances are in memory and valid.
    std::size_t validBlocks() const;

 private:
    static constexpr int kAxisBits = 6;
    static constexpr int kSquareShift = 3 * kAxisBits;
    /// Larger than any code, small enough to add a squared distance to.
    static constexpr std::int32_t kNothing = (1 << 30) - 1;

    using Codes = std::array<std::int32_t, kBlockCells<Dim>>;
    struct FieldBlock {
        bool valid = false;
        std::unique_ptr<Codes> codes;  ///< none: nothing within reach of any cell
    };
    struct Layer {
        double reach = 0;
        std::unordered_map<BlockKey<Dim>, FieldBlock, IndexHash> blocks;
    };
    /// Rows, planes and occupied cells around a block.
    struct Window;

    bool isCurrent(const Source& source, double reach) const;
    void update(const Source& source, double reach);
    void readAll(const Source& source);
    void readBlock(const Source& source, const BlockKey<Dim>& key);
    static void dropAround(Layer& layer, const BlockKey<Dim>& key,
                           const BlockMask<Dim>& changed);
    void compute(const BlockKey<Dim>& key, double reach, FieldBlock& block) const;
    /// \param onMissing called for a block that is not valid; nullptr: give up there
    /// \return false if it was given up
    template <class OnMissing>
    bool lookUp(const Cell<Dim>* cells, std::size_t count, Code* codes, OnMissing onMissing);

    mutable std::shared_mutex mutex_;
    typename ChangeLog<Dim>::Stamp stamp_ = 0;
    bool everRead_ = false;
    float occupiedFrom_ = 0;
    Layer near_, far_;  // far_ is not used while both have one reach
    OccupiedBlocks occupied_;
};

extern template class DistanceField<2>;
extern template class DistanceField<3>;

}  // namespace superray
