// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file voxel_view.h
/// The 3D view of a map, kept from one call to the next.

#include <superray/maps/mrpt_compat.h>
#include <superray/maps/options.h>
#include <superray/storage/occupancy_map.h>

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace superray {

/// Drawn voxels by block. Programs ask for the view at every step, so a call reads
/// only the blocks that changed since the last one, and copies what it has.
template <int Dim>
class VoxelView {
 public:
    /// Everything may have changed. A new view starts so.
    void forget() { built_ = false; }
    /// What was applied to the map; to be called for every change but those that
    /// forget() is for.
    void applied(const UpdateBatch<Dim>& batch);
    void applied(const CellCountMap<Dim>& counts);
    /// Blocks without known cells from now on.
    void forgotten(const std::vector<BlockKey<Dim>>& keys);

    /// Sets VOXEL_SET_OCCUPIED and VOXEL_SET_FREESPACE as the options say; the
    /// caller's own. 2D maps are drawn as cubes centred on z = 0. Safe to call
    /// concurrently; the other functions are for the writer of the map.
    std::shared_ptr<mrpt_viz::COctoMapVoxels> draw(const OccupancyMap<Dim>& map,
                                                   const SensorModel& model,
                                                   const TRenderingOptions& options);

    /// Blocks that the last draw() read from the map.
    std::size_t blocksRead() const { return blocksRead_; }

 private:
    using Voxel = mrpt_viz::COctoMapVoxels::TVoxel;
    using Key = BlockKey<Dim>;

    struct Block {
        std::array<std::vector<Voxel>, 2> sets;
        Cell<Dim> lowest, highest;  // of the drawn cells
    };
    /// All that decides how a known cell is drawn.
    struct Style {
        double resolution;
        SensorModel model;
        TRenderingOptions options;
        bool draws(float value) const {
            return value >= model.occupied() ? options.generateOccupiedVoxels
                                             : options.generateFreeVoxels;
        }
        bool sameAs(const Style& o) const;
    };

    /// Nobody may draw for long.
    void limitNotes();
    void refresh(const OccupancyMap<Dim>& map, const Style& style);
    void readBlock(const BlockView<Dim>& view, const CellGeometry<Dim>& geometry);
    /// \param z height of the centre
    mrpt::img::TColor colourOf(float value, float z) const;
    void scaleHeightColours();

    std::mutex drawing_;
    bool built_ = false;
    std::unique_ptr<Style> style_;
    std::map<Key, Block> blocks_;
    // Changed since the last draw(): with ends of rays, and with misses only.
    std::vector<Key> hit_, missed_;
    Cell<Dim> lowest_{}, highest_{};  // of all drawn cells
    double low_ = 0, high_ = 0;       // scale of the height colours
    std::size_t blocksRead_ = 0;
};

extern template class VoxelView<2>;
extern template class VoxelView<3>;

}  // namespace superray
